// A recording in the form of Record3D, packed by Apple's own encoder; record3d_samples/ has the program.
#include <cmath>

#include <gtest/gtest.h>
#include <zip.h>

#include "core/error.h"
#include "formats/damage.h"
#include "record3d/lzfse.h"
#include "record3d/record3d_reader.h"

namespace kinora::formats {
namespace {

using test::CopiedCapture;
using test::TemporaryFolder;
namespace fs = std::filesystem;

constexpr int kWidth = 64;
constexpr int kHeight = 48;
constexpr std::size_t kFrames = 3;

fs::path sample() { return fs::path(KINORA_RECORD3D_SAMPLES) / "sample.r3d"; }

TEST(Record3d, DepthConfidenceAndPosesOfApplesEncoderAreRead) {
  const CopiedCapture capture = test::read_capture(sample());
  EXPECT_EQ(capture.format, "record3d");
  EXPECT_TRUE(capture.warnings.empty());
  ASSERT_EQ(capture.frames.size(), kFrames);
  EXPECT_EQ(capture.info.camera.fy, 101);
  EXPECT_EQ(capture.info.depth_camera.width, kWidth);
  EXPECT_DOUBLE_EQ(capture.info.depth_camera.cx, 31.5);
  for (std::size_t i = 0; i < kFrames; ++i) {
    const test::CopiedFrame& frame = capture.frames[i];
    EXPECT_EQ(frame.problem, "");
    EXPECT_NEAR(frame.time, 10 + static_cast<double>(i) / 60, 1e-9);
    EXPECT_NEAR(frame.pose[3], 0.1 * static_cast<double>(i), 1e-9);
    EXPECT_EQ(frame.pose[5], -1); // ARKit's camera looks back along z, with y up
    EXPECT_EQ(frame.pose[10], -1);
    const auto* depth = reinterpret_cast<const std::uint16_t*>(frame.depth.data());
    const int f = static_cast<int>(i);
    for (int v = 0; v < kHeight; ++v) {
      for (int u = 0; u < kWidth; ++u) {
        const double metres = 1 + 0.01 * u + 0.003 * v + 0.1 * f + 0.001 * ((31 * u + 17 * v) % 5);
        const bool measured = (u + v + f) % 7 != 0;
        ASSERT_NEAR(depth[v * kWidth + u] * frame.depth_unit, measured ? metres : 0, 0.00013) << u << " " << v;
        ASSERT_EQ(std::to_integer<int>(frame.confidence[static_cast<std::size_t>(v * kWidth + u)]),
                  (u / 9 + v / 5 + f) % 3);
      }
    }
    EXPECT_FALSE(frame.jpeg.empty());
  }
}

TEST(Record3d, FilesThatAreCutAreRefused) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "a.r3d";
  fs::copy_file(sample(), path);
  test::expect_bears_truncation(path, path, "record3d", kFrames);
}

TEST(Record3d, AMissingDepthImageCostsItsFrameAlone) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "a.r3d";
  fs::copy_file(sample(), path);
  zip_t* const archive = zip_open(path.c_str(), 0, nullptr);
  ASSERT_EQ(zip_delete(archive, static_cast<zip_uint64_t>(zip_name_locate(archive, "rgbd/1.depth", 0))), 0);
  ASSERT_EQ(zip_close(archive), 0);
  const CopiedCapture capture = test::read_capture(path);
  ASSERT_EQ(capture.frames.size(), kFrames);
  EXPECT_EQ(capture.frames[0].problem, "");
  EXPECT_NE(capture.frames[1].problem.find("rgbd/1.depth is missing"), std::string::npos) << capture.frames[1].problem;
  EXPECT_EQ(capture.frames[2].problem, "");
}

TEST(Record3d, MetadataThatMakesNoSenseIsRefused) {
  for (const char* text : {"", "{}", R"({"K": 3, "w": 1, "h": 1})", R"({"K": [1,0,0,0,1,0,0,0,1], "w": 1e9, "h": 1})",
                           R"({"K": [9,0,0,0,9,0,4,4,1], "w": 8, "h": 8, "poses": [[0,0,0,0,1,1,1]]})"}) {
    const std::string json = text;
    try {
      (void)read_record3d_metadata(std::as_bytes(std::span(json)), "test");
      ADD_FAILURE() << text;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kCorruptInput) << error.what();
    }
  }
}

TEST(Lzfse, AnotherLengthOrADamagedBlockIsRefused) {
  // "bvx-", 3 bytes, "bvx$"
  const std::string stored("bvx-\x03\0\0\0abcbvx$", 15);
  const auto bytes = std::as_bytes(std::span(stored));
  EXPECT_EQ(unpack_lzfse(bytes, 3, "test").size(), 3U);
  EXPECT_THROW((void)unpack_lzfse(bytes, 4, "test"), Error);
  EXPECT_THROW((void)unpack_lzfse(bytes, 2, "test"), Error);
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_THROW((void)unpack_lzfse(bytes.first(size), 3, "test"), Error) << size;
}

} // namespace
} // namespace kinora::formats
