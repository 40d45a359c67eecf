// Recordings that OpenNI's own recorder made of a simulated camera; oni_samples/ has the programs.
#include <cmath>

#include <gtest/gtest.h>

#include "core/error.h"
#include "formats/capture_frames.h"
#include "formats/oni_samples/pattern.h"
#include "formats/sample_capture.h"
#include "openni/oni_pictures.h"
#include "openni/oni_reader.h"

namespace kinora::formats {
namespace {

using test::CopiedCapture;
using test::TemporaryFolder;
namespace fs = std::filesystem;
namespace oni = test::oni;

fs::path sample(const char* name) { return fs::path(KINORA_ONI_SAMPLES) / name; }

std::string contents(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Depth to the bit; colour within `tolerance`. Right and left are as the camera saw them, not as they were recorded.
void expect_pattern(const CopiedCapture& capture, int tolerance) {
  ASSERT_EQ(capture.frames.size(), std::size_t{oni::kFrames});
  for (int i = 0; i < oni::kFrames; ++i) {
    const test::CopiedFrame& frame = capture.frames[static_cast<std::size_t>(i)];
    ASSERT_EQ(frame.problem, "");
    EXPECT_NEAR(frame.time, i / oni::kFramesPerSecond, 1e-6);
    EXPECT_EQ(frame.depth_unit, 0.001);
    const auto* depth = reinterpret_cast<const std::uint16_t*>(frame.depth.data());
    for (int v = 0; v < oni::kHeight; ++v) {
      for (int u = 0; u < oni::kWidth; ++u) {
        const int pixel = v * oni::kWidth + u;
        ASSERT_EQ(depth[pixel], oni::depth_at(u, v, i)) << u << " " << v << " " << i;
        for (int c = 0; c < 3; ++c)
          ASSERT_NEAR(std::to_integer<int>(frame.color[static_cast<std::size_t>(3 * pixel + c)]),
                      oni::color_at(u, v, c, i), tolerance)
              << u << " " << v << " " << i;
      }
    }
  }
}

TEST(Oni, WhatItsOwnRecorderWroteIsReadToTheBit) {
  const CopiedCapture capture = test::read_capture(sample("lossless.oni"));
  EXPECT_EQ(capture.format, "oni");
  EXPECT_TRUE(capture.warnings.empty());
  EXPECT_EQ(capture.info.has_depth_camera, 0);
  EXPECT_NEAR(capture.info.camera.fx, oni::kWidth / 2.0 / std::tan(oni::kHorizontalView / 2.0), 1e-4);
  EXPECT_NEAR(capture.info.camera.fy, oni::kHeight / 2.0 / std::tan(oni::kVerticalView / 2.0), 1e-4);
  EXPECT_EQ(capture.info.camera.cx, (oni::kWidth - 1) / 2.0);
  EXPECT_NEAR(capture.info.frames_per_second, oni::kFramesPerSecond, 0.01);
  expect_pattern(capture, 0);
}

TEST(Oni, ColourMayBeJpeg) { expect_pattern(test::read_capture(sample("jpeg.oni")), 6); }

TEST(Oni, AnyFrameCanBeReadAtOnce) {
  OniReader reader(sample("lossless.oni"), 0);
  auto frame = make_struct<KinoraFrame>();
  reader.seek(7);
  ASSERT_EQ(reader.next(frame), KINORA_OK);
  EXPECT_EQ(static_cast<const std::uint16_t*>(frame.depth.data)[1], oni::depth_at(1, 0, 7));
  reader.seek(oni::kFrames);
  EXPECT_EQ(reader.next(frame), KINORA_END);
  EXPECT_THROW(reader.seek(oni::kFrames + 1), Error);
}

TEST(Oni, TheFocalLengthMayBeGiven) {
  const CopiedCapture capture = test::read_capture(sample("lossless.oni"), "oni", {{"focal", "29.29"}});
  EXPECT_EQ(capture.info.camera.fx, 29.29);
}

TEST(Oni, CamerasThatSeeDifferentlyFarAreTwo) {
  std::string file = contents(sample("lossless.oni"));
  const double wider = 1.2;
  std::memcpy(file.data() + file.find("xnFOV") + 6 + 4, &wider, sizeof wider); // of the first stream, depth
  const TemporaryFolder folder;
  folder.write("a.oni", file);
  const CopiedCapture capture = test::read_capture(folder.path() / "a.oni");
  ASSERT_EQ(capture.info.has_depth_camera, 1);
  EXPECT_NEAR(capture.info.depth_camera.fx, oni::kWidth / 2.0 / std::tan(0.6), 1e-4);
  for (int k = 0; k < 16; ++k) EXPECT_EQ(capture.info.depth_to_color[k], k % 5 == 0 ? 1 : 0);
  ASSERT_EQ(capture.warnings.size(), 1U);
  EXPECT_NE(capture.warnings.front().find("stand in one place"), std::string::npos);
}

/// Before version 1.0.1 the heads of records were shorter by the upper half of a place.
TEST(Oni, OlderFilesHaveShorterHeads) {
  const std::string file = contents(sample("lossless.oni"));
  std::string older = file.substr(0, 24);
  older[6] = 0; // 1.0.0.5
  older[8] = 5;
  const auto number = [&](std::size_t at) {
    std::uint32_t value;
    std::memcpy(&value, file.data() + at, sizeof value);
    return value;
  };
  for (std::size_t at = 24, type = 0; type != 0x0B;) {
    type = number(at + 4);
    const std::uint32_t fields = number(at + 12);
    const std::uint32_t payload = number(at + 16);
    std::string record = file.substr(at, fields + payload);
    const std::uint32_t shorter = fields - 4;
    std::memcpy(record.data() + 12, &shorter, sizeof shorter);
    older += record.erase(24, 4);
    at += fields + payload;
  }
  const TemporaryFolder folder;
  folder.write("old.oni", older);
  expect_pattern(test::read_capture(folder.path() / "old.oni"), 0);
}

TEST(Oni, AFileThatWasNotFinishedIsReadUpToThereWithAWarning) {
  const std::string file = contents(sample("lossless.oni"));
  const TemporaryFolder folder;
  folder.write("cut.oni", file.substr(0, file.size() / 2));
  const CopiedCapture capture = test::read_capture(folder.path() / "cut.oni");
  EXPECT_GE(capture.frames.size(), 4U);
  ASSERT_FALSE(capture.warnings.empty());
  EXPECT_NE(capture.warnings.front().find("what stands before is read"), std::string::npos);
}

// ---- packed pictures

std::vector<std::byte> bytes_of(std::initializer_list<int> values) {
  std::vector<std::byte> bytes;
  for (const int value : values) bytes.push_back(static_cast<std::byte>(value));
  return bytes;
}

OniStream stream_of(const char* codec, OniPixels pixels, int width, int height) {
  OniStream stream;
  stream.codec = codec;
  stream.pixels = pixels;
  stream.width = width;
  stream.height = height;
  return stream;
}

/// 1000, one more, the same; twice the same; two less by the short form alone; 64 more by the long one; 4000 in full.
TEST(OniDepth, DifferencesAddUp) {
  const std::vector<std::byte> packed = bytes_of({0xE8, 0x03, 0x56, 0xE1, 0x8D, 0xFF, 0x80, 0x6F, 0x0F, 0xA0});
  const DepthImage16 depth = oni_depth(packed, stream_of("16zP", OniPixels::kDepthMillimetres, 3, 3), "test");
  const std::vector<std::uint16_t> expected = {1000, 1001, 1001, 1001, 1001, 999, 1063, 1063, 4000};
  EXPECT_EQ(std::vector<std::uint16_t>(depth.values().begin(), depth.values().end()), expected);
}

TEST(OniDepth, DamagedBytesAreRefused) {
  const auto refused = [](std::initializer_list<int> bytes, const char* codec, int width) {
    EXPECT_THROW((void)oni_depth(bytes_of(bytes), stream_of(codec, OniPixels::kDepthMillimetres, width, 1), "test"),
                 Error);
  };
  refused({0xE8}, "16zP", 1);
  refused({0xE8, 0x03}, "16zP", 2);             // too few
  refused({0xE8, 0x03, 0xFE}, "16zP", 2);       // too many
  refused({0xE8, 0x03, 0xFF}, "16zP", 2);       // a long form that is cut
  refused({1, 0, 7, 0, 1, 0}, "16zT", 1);       // beyond the table
  refused({0xFF, 0xFF, 7, 0, 0, 0}, "16zT", 1); // a table that is cut
  refused({1, 0}, "Im8z", 1);                   // not known
  refused({1, 0}, "NONE", 2);                   // of another size
  refused({1, 0}, "NONE", 0);                   // absurd
  refused({1, 0}, "NONE", 1 << 20);
}

TEST(OniColor, EveryLayoutOfPixelsIsKnown) {
  const auto color = [](std::initializer_list<int> bytes, OniPixels pixels) {
    const ColorImage image = oni_color(bytes_of(bytes), stream_of("NONE", pixels, 2, 1), "test");
    return std::vector<int>(image.values().begin(), image.values().end());
  };
  EXPECT_EQ(color({1, 2, 3, 4, 5, 6}, OniPixels::kRgb), (std::vector<int>{1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(color({7, 9}, OniPixels::kGrey), (std::vector<int>{7, 7, 7, 9, 9, 9}));
  EXPECT_EQ(color({128, 16, 128, 235}, OniPixels::kUyvy), (std::vector<int>{0, 0, 0, 255, 255, 255}));
  EXPECT_EQ(color({16, 128, 235, 128}, OniPixels::kYuyv), (std::vector<int>{0, 0, 0, 255, 255, 255}));
  EXPECT_EQ(color({81, 90, 81, 240}, OniPixels::kYuyv), (std::vector<int>{254, 0, 0, 254, 0, 0})) << "red";
  EXPECT_THROW((void)color({1, 2, 3}, OniPixels::kRgb), Error);
  EXPECT_THROW((void)color({1, 2, 3, 4}, OniPixels::kOther), Error);
}

} // namespace
} // namespace kinora::formats
