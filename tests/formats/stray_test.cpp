// Folders of Stray Scanner, with a video that ffmpeg makes.
#include <cstdlib>

#include <gtest/gtest.h>

#include "core/error.h"
#include "formats/damage.h"
#include "stray_scanner/stray_reader.h"

namespace kinora::formats {
namespace {

namespace fs = std::filesystem;
using test::CopiedCapture;
using test::TemporaryFolder;

constexpr int kFrames = 6;

class StrayTest : public testing::Test {
protected:
  void SetUp() override {
    // Frame i is grey with level 40 i; 64x48 at 30 frames per second, H.264.
    const std::string command =
        "ffmpeg -v error -y -f lavfi -i \"color=black:s=64x48:r=30,format=gray,geq=lum='40*N'\" "
        "-frames:v 6 -pix_fmt yuv420p -color_range tv -colorspace bt709 '" +
        (folder_.path() / "rgb.mp4").string() + "'";
    if (std::system(command.c_str()) != 0) GTEST_SKIP() << "ffmpeg is not installed";
    std::string odometry = "timestamp, frame, x, y, z, qx, qy, qz, qw\n";
    for (int i = 0; i < kFrames; ++i) {
      odometry += std::to_string(50 + i / 30.0) + ", " + test::six_digits(i) + ", " + std::to_string(0.1 * i) +
                  ", 0, 0, 0, 0, 0.6, 0.8\n";
      folder_.write("depth/" + test::six_digits(i) + ".png", test::depth_bytes(i));
      folder_.write(
          "confidence/" + test::six_digits(i) + ".png",
          encode_png(ColorImage(test::kSampleWidth, test::kSampleHeight, 1, static_cast<std::uint8_t>(i % 3))));
    }
    folder_.write("odometry.csv", odometry);
    folder_.write("camera_matrix.csv", "80.0,0,31.5\n0,81.0,23.5\n0,0,1\n");
  }

  CopiedCapture read() { return test::read_capture(folder_.path()); }
  void expect_refused(const std::string& word) {
    try {
      (void)test::read_capture(folder_.path(), "stray-scanner");
      ADD_FAILURE() << word;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
    }
  }

  TemporaryFolder folder_;
};

TEST_F(StrayTest, VideoDepthConfidenceAndPosesComeTogether) {
  const CopiedCapture capture = read();
  EXPECT_EQ(capture.format, "stray-scanner");
  ASSERT_EQ(capture.frames.size(), static_cast<std::size_t>(kFrames));
  EXPECT_EQ(capture.info.camera.width, 64);
  EXPECT_EQ(capture.info.has_depth_camera, 1);
  EXPECT_EQ(capture.info.depth_camera.width, test::kSampleWidth);
  EXPECT_DOUBLE_EQ(capture.info.depth_camera.fx, 20);
  for (int i = 0; i < kFrames; ++i) {
    const test::CopiedFrame& frame = capture.frames[static_cast<std::size_t>(i)];
    EXPECT_EQ(frame.problem, "");
    EXPECT_NEAR(frame.time, 50 + i / 30.0, 1e-6);
    EXPECT_NEAR(frame.pose[3], 0.1 * i, 1e-6);
    EXPECT_NEAR(frame.pose[0], 0.28, 1e-6); // 2 acos 0.8 about z
    EXPECT_EQ(frame.confidence.front(), static_cast<std::byte>(i % 3));
    const DepthImage16 truth = decode_depth16(test::depth_bytes(i), "truth");
    EXPECT_EQ(std::memcmp(frame.depth.data(), truth.data(), frame.depth.size()), 0);
    // ffmpeg stores grey of level g as 16 + 219 g / 255, the range of video.
    EXPECT_NEAR(std::to_integer<int>(frame.color[3 * (24 * 64 + 32)]), 40 * i, 4) << i;
  }
}

TEST_F(StrayTest, AnyFrameCanBeReadAtOnce) {
  const host::PluginTable plugins = host::PluginTable::builtin();
  const CopiedCapture capture = read();
  host::FrameReader reader(plugins.find("stray-scanner"), folder_.path(), {});
  for (const int index : {5, 2, 0, 4}) {
    reader.seek(index);
    const auto frame = reader.next();
    ASSERT_TRUE(frame && frame->problem.empty()) << index;
    EXPECT_EQ(test::pixels_of(frame->frame.color), capture.frames[static_cast<std::size_t>(index)].color) << index;
  }
}

TEST_F(StrayTest, AMissingDepthImageCostsItsFrameAlone) {
  folder_.remove("depth/000002.png");
  const CopiedCapture capture = read();
  ASSERT_EQ(capture.frames.size(), static_cast<std::size_t>(kFrames));
  EXPECT_NE(capture.frames[2].problem.find("000002.png"), std::string::npos);
  EXPECT_EQ(capture.frames[3].problem, "");
}

TEST_F(StrayTest, DamagedFilesAreRefusedAtEveryLength) {
  test::expect_bears_truncation(folder_.path() / "rgb.mp4", folder_.path(), "stray-scanner", kFrames);
  test::expect_bears_truncation(folder_.path() / "odometry.csv", folder_.path(), "stray-scanner", kFrames);
  test::expect_bears_truncation(folder_.path() / "camera_matrix.csv", folder_.path(), "stray-scanner", kFrames);
}

TEST_F(StrayTest, WhatIsWrongIsNamed) {
  folder_.write("camera_matrix.csv", "1,2,3\n");
  expect_refused("camera_matrix.csv");
  folder_.write("odometry.csv", "timestamp, frame\n1, 2\n");
  expect_refused("odometry.csv");
  folder_.write("rgb.mp4", "no video");
  folder_.write("odometry.csv", "0, 0, 0, 0, 0, 0, 0, 0, 1\n");
  expect_refused("rgb.mp4");
}

TEST_F(StrayTest, TimesThatRunBackwardsArePutInOrderWithAWarning) {
  folder_.write("odometry.csv", "2, 1, 0, 0, 0, 0, 0, 0, 1\n1, 0, 0, 0, 0, 0, 0, 0, 1\n");
  const CopiedCapture capture = read();
  EXPECT_EQ(capture.warnings.size(), 1U);
  EXPECT_EQ(capture.frames.front().time, 1);
}

TEST_F(StrayTest, AVideoThatIsTurnedAgainstDepthIsRefused) {
  const fs::path video = folder_.path() / "rgb.mp4";
  const fs::path turned = folder_.path() / "turned.mp4";
  ASSERT_EQ(std::system(("ffmpeg -v error -y -i '" + video.string() + "' -c copy -metadata:s:v:0 rotate=90 '" +
                         turned.string() + "'")
                            .c_str()),
            0);
  fs::rename(turned, video);
  expect_refused("shown as 48x64");
}

} // namespace
} // namespace kinora::formats
