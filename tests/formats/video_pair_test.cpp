// A video beside a depth video, both made by ffmpeg.
#include <cstdlib>
#include <cstring>

#include <gtest/gtest.h>

#include "core/error.h"
#include "formats/damage.h"
#include "video_pair/hue_depth.h"

namespace kinora::formats {
namespace {

using test::CopiedCapture;
using test::TemporaryFolder;
namespace fs = std::filesystem;

constexpr int kFrames = 4;

class VideoPairTest : public testing::Test {
protected:
  void SetUp() override {
    for (int i = 0; i < kFrames; ++i) {
      folder_.write(std::string("c") + std::to_string(i) + ".png", test::color_bytes(i));
      folder_.write(std::string("d") + std::to_string(i) + ".png", test::depth_bytes(i));
    }
    folder_.write("in/intrinsics.json", test::kSampleIntrinsics);
    // RGB without loss; grey of 16 bits without loss.
    if (!make("c%d.png", "-c:v ffv1 -pix_fmt bgr0", "color.mkv") ||
        !make("d%d.png", "-c:v ffv1 -pix_fmt gray16le", "depth.mkv"))
      GTEST_SKIP() << "ffmpeg is not installed";
  }
  bool make(const std::string& pictures, const std::string& how, const std::string& name) const {
    const std::string from = (folder_.path() / pictures).string();
    const std::string to = (folder_.path() / "in" / name).string();
    const std::string command = "ffmpeg -v error -y -framerate 25 -i '" + from + "' " + how + " '" + to + "'";
    return std::system(command.c_str()) == 0;
  }
  CopiedCapture read(const host::Options& options = {}) {
    return test::read_capture(folder_.path() / "in", "", options);
  }

  TemporaryFolder folder_;
};

TEST_F(VideoPairTest, BothVideosAreReadToTheBit) {
  const CopiedCapture capture = read();
  EXPECT_EQ(capture.format, "video-pair");
  EXPECT_TRUE(capture.warnings.empty());
  ASSERT_EQ(capture.frames.size(), static_cast<std::size_t>(kFrames));
  EXPECT_NEAR(capture.info.frames_per_second, 25, 1e-6);
  EXPECT_EQ(capture.info.camera.fx, 20);
  for (int i = 0; i < kFrames; ++i) {
    const test::CopiedFrame& frame = capture.frames[static_cast<std::size_t>(i)];
    EXPECT_EQ(frame.problem, "");
    EXPECT_NEAR(frame.time, i / 25.0, 1e-6);
    const ColorImage color = decode_color(test::color_bytes(i), "truth");
    const DepthImage16 depth = decode_depth16(test::depth_bytes(i), "truth");
    EXPECT_EQ(std::memcmp(frame.color.data(), color.data(), frame.color.size()), 0) << i;
    EXPECT_EQ(std::memcmp(frame.depth.data(), depth.data(), frame.depth.size()), 0) << i;
    EXPECT_EQ(frame.depth_unit, 0.001);
  }
}

TEST_F(VideoPairTest, DepthInAnOrdinaryVideoIsReadAsHue) {
  fs::remove(folder_.path() / "in" / "depth.mkv");
  ASSERT_TRUE(
      make("c%d.png", "-vf geq=r=0:g=255:b=0 -c:v ffv1 -pix_fmt bgr0", "depth.mkv")); // green: a third of the way
  const CopiedCapture capture = read({{"near", "1"}, {"far", "4"}});
  ASSERT_EQ(capture.frames.size(), static_cast<std::size_t>(kFrames));
  const auto* depth = reinterpret_cast<const std::uint16_t*>(capture.frames[0].depth.data());
  EXPECT_NEAR(depth[20] * capture.frames[0].depth_unit, 2, 1e-9);
  ASSERT_EQ(capture.warnings.size(), 1U);
  EXPECT_NE(capture.warnings[0].find("hue"), std::string::npos);
  EXPECT_THROW((void)read({{"near", "5"}, {"far", "4"}}), Error);
}

TEST_F(VideoPairTest, AnyFrameCanBeReadAtOnce) {
  const CopiedCapture capture = read();
  const host::PluginTable plugins = host::PluginTable::builtin();
  host::FrameReader reader(plugins.find("video-pair"), folder_.path() / "in", {});
  for (const int index : {3, 1, 0, 2}) {
    reader.seek(index);
    const auto frame = reader.next();
    ASSERT_TRUE(frame && frame->problem.empty()) << index;
    EXPECT_EQ(test::pixels_of(frame->frame.depth), capture.frames[static_cast<std::size_t>(index)].depth) << index;
  }
}

/// Phones store pictures as the sensor lies, and say in the file how they are turned. ffmpeg turns them when it copies
/// pictures, not when it copies a stream.
TEST_F(VideoPairTest, VideosThatSayHowTheyAreTurnedAreTurnedAsFfmpegDoes) {
  const fs::path in = folder_.path() / "in";
  const auto ffmpeg = [](const fs::path& from, const std::string& how, const fs::path& to) {
    return std::system(("ffmpeg -v error -y -i '" + from.string() + "' " + how + " '" + to.string() + "'").c_str());
  };
  for (const char* name : {"color", "depth"})
    fs::rename(in / (std::string(name) + ".mkv"), folder_.path() / (std::string(name) + ".mkv"));
  for (const int degrees : {90, 180, 270}) {
    const bool lies = degrees != 180;
    folder_.write("in/intrinsics.json",
                  lies ? R"({"fx": 20, "fy": 20, "cx": 5.5, "cy": 7.5, "width": 12, "height": 16})"
                       : R"({"fx": 20, "fy": 20, "cx": 7.5, "cy": 5.5, "width": 16, "height": 12})");
    for (const std::string name : {"color", "depth"}) {
      const std::string turn = "-c copy -metadata:s:v:0 rotate=" + std::to_string(degrees);
      ASSERT_EQ(ffmpeg(folder_.path() / (name + ".mkv"), turn, in / (name + ".mov")), 0);
    }
    const CopiedCapture by_us = read();
    for (const std::string name : {"color", "depth"}) {
      ASSERT_EQ(ffmpeg(in / (name + ".mov"), "-c:v ffv1", in / (name + ".mkv")), 0);
      fs::remove(in / (name + ".mov"));
    }
    const CopiedCapture by_ffmpeg = read();
    ASSERT_EQ(by_us.frames.size(), by_ffmpeg.frames.size());
    for (std::size_t i = 0; i < by_us.frames.size(); ++i) {
      EXPECT_EQ(by_us.frames[i].problem, "");
      EXPECT_EQ(by_us.frames[i].color, by_ffmpeg.frames[i].color) << degrees;
      EXPECT_EQ(by_us.frames[i].depth, by_ffmpeg.frames[i].depth) << degrees;
    }
    for (const std::string name : {"color", "depth"}) fs::remove(in / (name + ".mkv"));
  }
}

TEST_F(VideoPairTest, DamagedFilesAreRefusedAtEveryLength) {
  const fs::path in = folder_.path() / "in";
  for (const char* name : {"color.mkv", "depth.mkv", "intrinsics.json"})
    test::expect_bears_truncation(in / name, in, "video-pair", kFrames);
}

TEST(HueDepth, GreyAndDarkPixelsAreNoMeasurement) {
  ColorImage image(4, 1, 3);
  const std::uint8_t pixels[] = {255, 0, 0, 128, 128, 128, 20, 0, 0, 0, 0, 255};
  std::copy(std::begin(pixels), std::end(pixels), image.data());
  const DepthImage16 depth = depth_of_hue(image, {1, 4});
  EXPECT_EQ(depth.at(0, 0), 2000);
  EXPECT_EQ(depth.at(1, 0), 0);
  EXPECT_EQ(depth.at(2, 0), 0);
  EXPECT_EQ(depth.at(3, 0), 6000); // blue: two thirds
}

} // namespace
} // namespace kinora::formats
