// A live camera of OpenNI: its library itself, with a simulated camera as its only driver.
#include <cmath>

#include "cli/run_kinora.h"
#include "formats/capture_frames.h"
#include "formats/oni_samples/pattern.h"

namespace kinora::test {
namespace {

class OpenNi : public testing::Test {
protected:
  Said run(const std::vector<std::string>& words) const {
    setenv("LD_LIBRARY_PATH", KINORA_SIMULATED_OPENNI, 1); // drivers are looked for beside the library
    Said said = run_kinora(out_, words);
    unsetenv("LD_LIBRARY_PATH");
    return said;
  }
  std::string out(const char* name) const { return (out_.path() / name).string(); }

  /// The library drops frames if its own thread comes late: those that come are whole, and in order.
  void expect_frames(const char* file, double end) const {
    const CopiedCapture capture = read_capture(out(file));
    ASSERT_GE(capture.frames.size(), 1U);
    EXPECT_NEAR(capture.info.camera.fx, oni::kWidth / 2.0 / std::tan(oni::kHorizontalView / 2.0), 1e-4);
    EXPECT_EQ(capture.info.has_depth_camera, 0) << "the camera registers depth itself";
    const auto first_depth = reinterpret_cast<const std::uint16_t*>(capture.frames.front().depth.data())[31];
    const int first = (first_depth - 4000) / 100; // what it saw before anybody listened
    double last = -1;
    for (const CopiedFrame& frame : capture.frames) {
      EXPECT_GT(frame.time, last);
      EXPECT_LE(frame.time, end);
      last = frame.time;
      const int i = first + static_cast<int>(std::lround(frame.time * oni::kFramesPerSecond));
      const auto* depth = reinterpret_cast<const std::uint16_t*>(frame.depth.data());
      for (int v = 0; v < oni::kHeight; ++v) {
        for (int u = 0; u < oni::kWidth; ++u) {
          const int pixel = v * oni::kWidth + u;
          ASSERT_EQ(depth[pixel], oni::depth_at(u, v, i)) << u << " " << v << " " << i;
          ASSERT_EQ(std::to_integer<int>(frame.color[static_cast<std::size_t>(3 * pixel)]), oni::color_at(u, v, 0, i));
        }
      }
    }
  }

  TemporaryFolder out_;
};

TEST_F(OpenNi, ALiveCameraIsRecordedAsLongAsOneLikes) {
  const Said said = run({"record", "openni:0", out("r.mkv"), "-O", "seconds=0.15"});
  ASSERT_EQ(said.code, 0) << said.err;
  expect_frames("r.mkv", 0.15);
}

TEST_F(OpenNi, ACameraThatFallsSilentIsNamedAndWhatCameIsKept) {
  expect_error(run({"record", "openni:simulated", out("r.mkv")}), 1, "is complete up to there");
  expect_frames("r.mkv", 0.4);
}

TEST_F(OpenNi, WhatIsNoCameraIsRefused) {
  expect_error(run({"record", "openni:1", out("r.mkv")}), 6, "there is no such camera, but 1");
  expect_error(run({"record", "openni:elsewhere", out("r.mkv")}), 6, "cannot be opened");
  expect_error(run({"record", "openni:0", out("r.mkv"), "-O", "seconds=0"}), 2, "seconds must lie");
  EXPECT_FALSE(fs::exists(out("r.mkv")));
}

} // namespace
} // namespace kinora::test
