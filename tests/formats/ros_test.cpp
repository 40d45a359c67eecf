// ROS logs that ROS's own writer and Foxglove's made; ros_samples/ has the programs.
#include <cstring>

#include <gtest/gtest.h>

#include "core/error.h"
#include "formats/damage.h"
#include "formats/oni_samples/pattern.h"
#include "ros/message_log.h"
#include "ros/messages.h"
#include "ros/ros_images.h"
#include "ros/rvl.h"

namespace kinora::formats {
namespace {

using test::CopiedCapture;
using test::TemporaryFolder;
namespace fs = std::filesystem;

constexpr int kWidth = 16;
constexpr int kHeight = 12;
constexpr int kFrames = 3;

fs::path sample(const std::string& name) { return fs::path(KINORA_ROS_SAMPLES) / name; }

/// As the programs in ros_samples/ draw it.
std::vector<std::byte> true_color(int frame) {
  std::vector<std::byte> out;
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u)
      for (int c = 0; c < 3; ++c) out.push_back(static_cast<std::byte>((7 * u + 13 * v + 50 * c + 11 * frame) % 256));
  return out;
}

/// Units per millimetre: 1, or 4 where metres were floats.
std::vector<std::byte> true_depth(int frame, int scale = 1) {
  std::vector<std::uint16_t> out;
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u)
      out.push_back(
          static_cast<std::uint16_t>((u + v + frame) % 7 == 0 ? 0 : scale * (1000 + 10 * u + 3 * v + 100 * frame)));
  const auto bytes = std::as_bytes(std::span(out));
  return {bytes.begin(), bytes.end()};
}

void expect_frames(const CopiedCapture& capture, int depth_scale = 1) {
  EXPECT_TRUE(capture.warnings.empty()) << capture.warnings.front();
  ASSERT_EQ(capture.frames.size(), static_cast<std::size_t>(kFrames));
  EXPECT_EQ(capture.info.camera.fx, 20);
  EXPECT_EQ(capture.info.camera.cy, 5.5);
  EXPECT_DOUBLE_EQ(capture.info.frames_per_second, 32);
  for (int i = 0; i < kFrames; ++i) {
    const test::CopiedFrame& frame = capture.frames[static_cast<std::size_t>(i)];
    EXPECT_EQ(frame.problem, "");
    EXPECT_EQ(frame.time, 1600000000.25 + i / 32.0) << "the sender's clock, not the logger's";
    EXPECT_EQ(frame.color, true_color(i));
    EXPECT_EQ(frame.depth, true_depth(i, depth_scale));
  }
}

TEST(RosBag, AlignedDepthIsChosenAndReadToTheBitFromLz4) {
  const CopiedCapture capture = test::read_capture(sample("aligned_lz4.bag"));
  EXPECT_EQ(capture.format, "ros-bag");
  expect_frames(capture);
  EXPECT_EQ(capture.info.has_depth_camera, 0);
  EXPECT_EQ(capture.info.camera.distortion[1], -0.2);
  EXPECT_EQ(capture.frames[0].depth_unit, 0.001);
}

TEST(RosBag, RealSenseRecordingsBringUnitAndPlaceOfTheDepthCamera) {
  const CopiedCapture capture = test::read_capture(sample("librealsense.bag"));
  expect_frames(capture);
  EXPECT_EQ(capture.frames[0].depth_unit, 0.00025);
  EXPECT_EQ(capture.info.has_depth_camera, 1);
  EXPECT_EQ(capture.info.depth_camera.fx, 18);
  EXPECT_DOUBLE_EQ(capture.info.depth_to_color[3], 0.015);
}

TEST(RosBag, CompressedImagesAndTransformsAreReadFromBzip2) {
  const CopiedCapture capture = test::read_capture(sample("compressed_bz2.bag"));
  expect_frames(capture);
  EXPECT_EQ(capture.info.has_depth_camera, 1);
  EXPECT_NEAR(capture.info.depth_to_color[3], -0.03, 1e-12); // the colour camera stands 3 cm to the right
}

TEST(Mcap, Ros2ImagesAreReadFromEveryCompression) {
  for (const char* name : {"plain.mcap", "zstd.mcap", "lz4.mcap"}) {
    SCOPED_TRACE(name);
    const CopiedCapture capture = test::read_capture(sample(name));
    EXPECT_EQ(capture.format, "mcap");
    expect_frames(capture, 4); // floats in metres become units of 0.25 mm
    EXPECT_EQ(capture.frames[0].depth_unit, 0.00025);
    EXPECT_NEAR(capture.info.depth_to_color[3], -0.03, 1e-12);
  }
}

TEST(RosLog, ATopicThatIsNamedIsTaken) {
  const CopiedCapture capture =
      test::read_capture(sample("aligned_lz4.bag"), "", {{"depth", "/camera/aligned_depth_to_color/image_raw"}});
  expect_frames(capture);
  try {
    (void)test::read_capture(sample("aligned_lz4.bag"), "", {{"color", "/camera/none"}});
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("/camera/color/image_raw"), std::string::npos) << error.what();
  }
}

TEST(RosLog, FilesThatAreCutAreReadUpToThereOrRefused) {
  const TemporaryFolder folder;
  for (const char* name : {"aligned_lz4.bag", "librealsense.bag", "compressed_bz2.bag", "plain.mcap", "zstd.mcap"}) {
    SCOPED_TRACE(name);
    const fs::path path = folder.path() / name;
    fs::copy_file(sample(name), path);
    test::expect_bears_truncation(path, path, path.extension() == ".bag" ? "ros-bag" : "mcap", kFrames);
  }
}

TEST(RosLog, AFileThatWasNotFinishedIsReadWithAWarning) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "a.mcap";
  fs::copy_file(sample("plain.mcap"), path);
  fs::resize_file(path, 14 * fs::file_size(path) / 20); // inside of the third frame
  const CopiedCapture capture = test::read_capture(path);
  EXPECT_GE(capture.frames.size(), 1U);
  ASSERT_FALSE(capture.warnings.empty());
  EXPECT_NE(capture.warnings.front().find("a.mcap"), std::string::npos);
}

TEST(RosLog, AnotherMagicIsNotRecognised) {
  const TemporaryFolder folder;
  folder.write("a.bag", "#ROSBAG V1.2\n and more");
  for (const char* format : {"ros-bag", "mcap"}) {
    try {
      (void)test::read_capture(folder.path() / "a.bag", format);
      ADD_FAILURE();
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kNotRecognised) << error.what();
    }
  }
}

TEST(RosMessage, SizesThatGoBeyondTheMessageAreRefused) {
  std::vector<std::byte> bytes(64);
  bytes[16] = bytes[17] = bytes[18] = bytes[19] = std::byte{0xff};
  const MessageBytes message{bytes, MessageEncoding::kRos1, "test"};
  for (const auto& parse : {+[](const MessageBytes& m) { (void)image_of(m, false); },
                            +[](const MessageBytes& m) { (void)camera_info_of(m); },
                            +[](const MessageBytes& m) { (void)transforms_of(m); }}) {
    try {
      parse(message);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kCorruptInput);
    }
  }
  const std::vector<std::byte> absurd(8, std::byte{0xff});
  EXPECT_THROW((void)transforms_of({absurd, MessageEncoding::kRos1, "test"}), Error);
}

// ---- depth packed with RVL

/// As the paper's listing does it: runs of zeros and of differences, in groups of three bits and one that says "more".
std::vector<std::byte> pack_rvl(const DepthImage16& image) {
  std::vector<std::uint32_t> words{static_cast<std::uint32_t>(image.width()),
                                   static_cast<std::uint32_t>(image.height())};
  std::uint32_t word = 0;
  int groups = 0;
  const auto put = [&](std::uint32_t value) {
    do {
      std::uint32_t group = value & 7U;
      value >>= 3;
      if (value != 0) group |= 8U;
      word = word << 4 | group;
      if (++groups == 8) {
        words.push_back(word);
        groups = 0;
      }
    } while (value != 0);
  };
  const std::span values = image.values();
  int last = 0;
  for (std::size_t i = 0; i < values.size();) {
    std::uint32_t zeros = 0, others = 0;
    for (; i < values.size() && values[i] == 0; ++i) ++zeros;
    for (std::size_t k = i; k < values.size() && values[k] != 0; ++k) ++others;
    put(zeros);
    put(others);
    for (; others > 0; --others, ++i) {
      const int difference = values[i] - last;
      put(static_cast<std::uint32_t>(difference << 1 ^ difference >> 31));
      last = values[i];
    }
  }
  if (groups > 0) words.push_back(word << 4 * (8 - groups));
  const auto bytes = std::as_bytes(std::span(words));
  return {bytes.begin(), bytes.end()};
}

/// The message that carries it: 12 bytes of a header, and the packed image.
std::vector<std::byte> rvl_message(const DepthImage16& image, float a = 0, float b = 0) {
  std::vector<std::byte> bytes(12);
  std::memcpy(bytes.data() + 4, &a, sizeof a);
  std::memcpy(bytes.data() + 8, &b, sizeof b);
  const std::vector<std::byte> packed = pack_rvl(image);
  bytes.insert(bytes.end(), packed.begin(), packed.end());
  return bytes;
}

ImageMessage message_of(const std::vector<std::byte>& bytes, const char* encoding) {
  ImageMessage message;
  message.encoding = encoding;
  message.data = bytes;
  return message;
}

TEST(Rvl, APackedImageIsUnpackedAsThePaperSays) {
  // 2x2: 0 5 5 0. One zero, two others: +5 (folded 10: groups 2+more, 1), +0; one zero, no other.
  const std::uint32_t words[] = {2, 2, 0x12A10100U};
  const DepthImage16 image = unpack_rvl(std::as_bytes(std::span(words)), "a");
  EXPECT_EQ(std::vector<std::uint16_t>(image.values().begin(), image.values().end()),
            (std::vector<std::uint16_t>{0, 5, 5, 0}));
}

TEST(Rvl, DepthComesBackToTheBit) {
  DepthImage16 image = test::sample_depth(33, 21, 900);
  for (std::size_t i = 0; i < image.pixel_count(); i += 5) image.data()[i] = 0;
  image.at(3, 3) = 65535;
  image.at(4, 3) = 1;
  const std::vector<std::byte> bytes = rvl_message(image);
  EXPECT_TRUE(is_depth_encoding("16UC1; compressedDepth rvl", true));
  const DepthImage16 back = depth_image_of(message_of(bytes, "16UC1; compressedDepth rvl"), true, "a");
  EXPECT_TRUE(std::ranges::equal(back.values(), image.values()));
  EXPECT_TRUE(std::ranges::all_of(
      depth_image_of(message_of(rvl_message(DepthImage16(8, 8, 1, 0)), "16UC1; compressedDepth rvl"), true, "a")
          .values(),
      [](std::uint16_t value) { return value == 0; }));
}

TEST(Rvl, WhatRosPackedIsUnpackedToTheBit) {
  std::ifstream file(fs::path(KINORA_ROS_SAMPLES) / "image_transport.rvl", std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  const DepthImage16 image = unpack_rvl(std::as_bytes(std::span(bytes)), "a");
  ASSERT_EQ(image.width(), test::oni::kWidth);
  ASSERT_EQ(image.height(), test::oni::kHeight);
  for (int v = 0; v < image.height(); ++v)
    for (int u = 0; u < image.width(); ++u) ASSERT_EQ(image.at(u, v), test::oni::depth_at(u, v, 3)) << u << " " << v;
}

TEST(Rvl, MetresThatWereFloatsAreInverted) {
  const std::vector<std::byte> bytes = rvl_message(DepthImage16(2, 1, 1, 100), 100, 50); // 100 / (100 - 50) = 2 m
  const DepthImage16 back = depth_image_of(message_of(bytes, "32FC1; compressedDepth rvl"), true, "a");
  EXPECT_EQ(back.at(0, 0), 8000);
}

TEST(Rvl, DamagedBytesAndAbsurdSizesAreRefused) {
  const std::vector<std::byte> whole = pack_rvl(test::sample_depth(33, 21, 900));
  for (std::size_t length = 0; length < whole.size(); length += 7)
    EXPECT_THROW((void)unpack_rvl(std::span(whole).first(length), "a"), Error) << length;
  for (const auto& [width, height] : {std::pair{0U, 3U}, {70000U, 1U}, {16384U, 16384U}}) {
    const std::uint32_t words[] = {width, height, 0xFFFFFFFFU};
    EXPECT_THROW((void)unpack_rvl(std::as_bytes(std::span(words)), "a"), Error);
  }
  const std::uint32_t endless[] = {2, 2, 0xFFFFFFFFU, 0xFFFFFFFFU};
  EXPECT_THROW((void)unpack_rvl(std::as_bytes(std::span(endless)), "a"), Error);
}

} // namespace
} // namespace kinora::formats
