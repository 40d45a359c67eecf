// A live Kinect, simulated (simulated_kinect.c) in the place of libfreenect.
#include "cli/run_kinora.h"
#include "formats/capture_frames.h"

namespace kinora::test {
namespace {

constexpr int kPixels = 640 * 480;

class Freenect : public testing::Test {
protected:
  Said run(const std::vector<std::string>& words) const {
    setenv("LD_PRELOAD", KINORA_SIMULATED_KINECT, 1);
    Said said = run_kinora(out_, words);
    unsetenv("LD_PRELOAD");
    return said;
  }
  std::string out(const char* name) const { return (out_.path() / name).string(); }

  TemporaryFolder out_;
};

TEST_F(Freenect, ALiveCameraIsRecordedAsLongAsOneLikes) {
  const Said said = run({"record", "freenect:0", out("r.mkv"), "-O", "seconds=0.25", "-O", "focal=530"});
  ASSERT_EQ(said.code, 0) << said.err;
  const CopiedCapture capture = read_capture(out("r.mkv"));
  ASSERT_EQ(capture.frames.size(), 8U) << "0 to 7 thirtieths of a second";
  EXPECT_EQ(capture.info.camera.fx, 530);
  EXPECT_EQ(capture.info.has_depth_camera, 0) << "the camera registers depth itself";
  for (int i = 0; i < 8; ++i) {
    const CopiedFrame& frame = capture.frames[static_cast<std::size_t>(i)];
    EXPECT_NEAR(frame.time, i / 30.0, 1e-6) << "also where the camera's clock begins anew";
    EXPECT_EQ(frame.color.back(), static_cast<std::byte>(20 * i));
    const auto* depth = reinterpret_cast<const std::uint16_t*>(frame.depth.data());
    for (const int pixel : {0, 5, kPixels - 1}) EXPECT_EQ(depth[pixel], 1000 + 10 * i + pixel % 7);
    EXPECT_EQ(frame.depth_unit, 0.001);
  }
}

TEST_F(Freenect, ACameraThatFallsSilentIsNamedAndWhatCameIsKept) {
  expect_error(run({"record", "freenect:", out("r.mkv")}), 1, "is complete up to there");
  EXPECT_EQ(read_capture(out("r.mkv")).frames.size(), 12U);
}

TEST_F(Freenect, WhatIsNoCameraIsRefused) {
  expect_error(run({"record", "freenect:1", out("r.mkv")}), 6, "there is no such camera, but 1");
  expect_error(run({"record", "freenect:x", out("r.mkv")}), 2, "freenect:0 for the first");
  expect_error(run({"record", "freenekt:0", out("r.mkv")}), 2, "freenekt:0");
  EXPECT_FALSE(fs::exists(out("r.mkv")));
}

} // namespace
} // namespace kinora::test
