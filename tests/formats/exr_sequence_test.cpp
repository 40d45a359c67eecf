// OpenEXR files as a capture: those of Kinora, and those that others write.
#include <algorithm>
#include <list>

#include <gtest/gtest.h>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDoubleAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStandardAttributes.h>

#include "formats/damage.h"
#include "host/frame_writer.h"
#include "host/interface_struct.h"

namespace kinora::formats {
namespace {

using namespace kinora::test;

constexpr int kFrames = 3;

/// A file of floats by name; `window` is the data window, the picture has kSampleWidth by kSampleHeight pixels.
void write_exr(
    const fs::path& path, const std::map<std::string, float>& channels, const Imath::Box2i& window,
    const std::function<void(Imf::Header&)>& change = [](Imf::Header&) {}) {
  Imf::Header header({{0, 0}, {kSampleWidth - 1, kSampleHeight - 1}}, window);
  const std::size_t columns = static_cast<std::size_t>(window.max.x - window.min.x) + 1;
  const std::size_t rows = static_cast<std::size_t>(window.max.y - window.min.y) + 1;
  std::list<std::vector<float>> values;
  Imf::FrameBuffer buffer;
  for (const auto& [name, value] : channels) {
    header.channels().insert(name, Imf::Channel(Imf::FLOAT));
    values.emplace_back(columns * rows, value);
    buffer.insert(name, Imf::Slice::Make(Imf::FLOAT, values.back().data(), window));
  }
  change(header);
  Imf::OutputFile file(path.c_str(), header);
  file.setFrameBuffer(buffer);
  file.writePixels(static_cast<int>(rows));
}

const Imath::Box2i kWhole({0, 0}, {kSampleWidth - 1, kSampleHeight - 1});

class ExrSequence : public testing::Test {
protected:
  void write_frames(const char* depth = "Z", const std::string& layer = "") const {
    for (int i = 0; i < kFrames; ++i)
      write_exr(file(i),
                {{layer + "R", 1.0F}, {layer + "G", 0.5F}, {layer + "B", 0.0F}, {depth, 1.25F + static_cast<float>(i)}},
                kWhole);
  }
  fs::path file(int number) const { return folder_.path() / ("render" + std::to_string(number + 8) + ".exr"); }
  CopiedCapture read() const { return read_capture(folder_.path()); }
  static double depth_at(const CopiedFrame& frame, std::size_t pixel) {
    return frame.depth_unit * reinterpret_cast<const std::uint16_t*>(frame.depth.data())[pixel];
  }

  TemporaryFolder folder_;
};

TEST_F(ExrSequence, WhatARendererWritesIsReadInTheOrderOfItsNumbers) {
  write_frames(); // 8, 9, 10
  folder_.write("intrinsics.json", kSampleIntrinsics);
  const CopiedCapture capture = read();
  EXPECT_EQ(capture.format, "exr-sequence");
  ASSERT_EQ(capture.frames.size(), 3U);
  EXPECT_EQ(capture.info.camera.fx, 20);
  for (std::size_t i = 0; i < capture.frames.size(); ++i) {
    const CopiedFrame& frame = capture.frames[i];
    EXPECT_EQ(frame.problem, "");
    EXPECT_NEAR(frame.time, static_cast<double>(i) / 30, 1e-12);
    EXPECT_EQ(depth_at(frame, 7), 1.25 + static_cast<double>(i));
    EXPECT_EQ(frame.color[0], std::byte{255});
    EXPECT_EQ(frame.color[1], std::byte{188}) << "half the light";
    EXPECT_EQ(frame.color[2], std::byte{0});
    EXPECT_FALSE(frame.has_pose);
  }
}

TEST_F(ExrSequence, LayersOfARendererAreFound) {
  write_frames("ViewLayer.Depth.Z", "ViewLayer.Combined.");
  folder_.write("intrinsics.json", kSampleIntrinsics);
  EXPECT_EQ(depth_at(read().frames.at(1), 0), 2.25);
}

TEST_F(ExrSequence, PixelsOutsideOfTheDataWindowAreEmptyAndFarOnesAreNoMeasurement) {
  const Imath::Box2i window({2, 1}, {kSampleWidth + 3, 4});
  write_exr(file(0), {{"R", 1.0F}, {"G", 1.0F}, {"B", 1.0F}, {"Z", 2.0F}}, window);
  write_exr(file(1), {{"R", 1.0F}, {"G", 1.0F}, {"B", 1.0F}, {"Z", 1e10F}}, kWhole);
  folder_.write("intrinsics.json", kSampleIntrinsics);
  const CopiedCapture capture = read();
  const CopiedFrame& frame = capture.frames.at(0);
  EXPECT_EQ(depth_at(frame, 0), 0);
  EXPECT_EQ(depth_at(frame, kSampleWidth + 1), 0);
  EXPECT_EQ(depth_at(frame, kSampleWidth + 2), 2);
  EXPECT_EQ(depth_at(frame, 5 * kSampleWidth + 2), 0);
  EXPECT_EQ(frame.color[3 * kSampleWidth], std::byte{0});
  EXPECT_EQ(depth_at(capture.frames.at(1), 0), 0);
}

TEST_F(ExrSequence, TheCameraOfTheFilesIsTakenWhereThereIsNoIntrinsicsFile) {
  for (int i = 0; i < kFrames; ++i)
    write_exr(file(i), {{"R", 1.0F}, {"G", 1.0F}, {"B", 1.0F}, {"Z", 2.0F}}, kWhole, [i](Imf::Header& header) {
      for (const auto& [name, value] : std::map<std::string, double>{{"fl_x", 20}, {"fl_y", 21}, {"cx", 8}, {"cy", 6}})
        header.insert(name, Imf::DoubleAttribute(value));
      Imath::M44f world_to_camera;
      world_to_camera.setTranslation(Imath::V3f(static_cast<float>(i), 2, 3)); // axes there: x right, y up, z back
      Imf::addWorldToCamera(header, world_to_camera);
    });
  const CopiedCapture capture = read();
  EXPECT_EQ(capture.info.camera.cx, 7.5);
  EXPECT_EQ(capture.info.has_poses, 1);
  EXPECT_NEAR(capture.frames.at(1).pose[3], -1, 1e-6);
  EXPECT_NEAR(capture.frames.at(1).pose[7], 2, 1e-6);
  EXPECT_NEAR(capture.frames.at(1).pose[11], 3, 1e-6);
}

TEST_F(ExrSequence, TimesThatRunBackwardsPutTheFramesInOrder) {
  for (int i = 0; i < kFrames; ++i)
    write_exr(file(i), {{"R", 1.0F}, {"G", 1.0F}, {"B", 1.0F}, {"Z", 1.0F + static_cast<float>(i)}}, kWhole,
              [i](Imf::Header& header) { header.insert("time", Imf::DoubleAttribute(5.0 - i)); });
  folder_.write("intrinsics.json", kSampleIntrinsics);
  const CopiedCapture capture = read();
  ASSERT_EQ(capture.warnings.size(), 1U);
  EXPECT_NE(capture.warnings[0].find("out of order"), std::string::npos);
  EXPECT_EQ(capture.frames.at(0).time, 3);
  EXPECT_EQ(depth_at(capture.frames[0], 0), 3);
}

TEST_F(ExrSequence, EveryCodeOfColourAndEveryUnitOfDepthComesBack) {
  ColorImage color(256, 256, 3);
  DepthImage16 depth(256, 256);
  for (std::size_t i = 0; i < depth.pixel_count(); ++i) {
    depth.data()[i] = static_cast<std::uint16_t>(i);
    for (std::size_t c = 0; c < 3; ++c) color.data()[3 * i + c] = static_cast<std::uint8_t>(i + 7 * c);
  }
  const host::PluginTable plugins = host::PluginTable::builtin();
  for (const double unit : {0.001, 0.0002, 0.00025, 1.0 / 3000}) {
    auto info = host::make_struct<KinoraCaptureInfo>();
    info.frame_count = 1;
    info.frames_per_second = 30;
    info.camera = {256, 256, 200, 200, 128, 128, {}, {}};
    const TemporaryFolder out;
    host::FrameWriter writer(plugins.find("exr-sequence"), out.path(), {}, info);
    auto frame = host::make_struct<KinoraFrame>();
    frame.depth_unit = unit;
    frame.color = {256, 256, 3, KINORA_PIXEL_U8, 3 * 256, color.data(), {}};
    frame.depth = {256, 256, 1, KINORA_PIXEL_U16, 2 * 256, depth.data(), {}};
    ASSERT_EQ(writer.write(frame), "");
    writer.finish();
    const CopiedCapture capture = read_capture(out.path());
    EXPECT_EQ(capture.frames.at(0).depth, pixels_of(frame.depth)) << unit;
    EXPECT_EQ(capture.frames.at(0).color, pixels_of(frame.color)) << unit;
    EXPECT_EQ(capture.frames.at(0).depth_unit, unit);
  }
}

TEST_F(ExrSequence, DamagedFilesAreRefusedAtEveryLength) {
  write_frames();
  folder_.write("intrinsics.json", kSampleIntrinsics);
  expect_bears_truncation(file(0), folder_.path(), "exr-sequence", kFrames);
  fs::remove(file(1));
  fs::remove(file(2));
  expect_bears_truncation(file(0), folder_.path(), "exr-sequence", 1);
}

/// The library would read on in the middle of the next attribute, and allocate whatever size it finds there.
TEST_F(ExrSequence, AttributesOfAnotherLengthThanTheirTypeAreRefused) {
  write_frames();
  folder_.write("intrinsics.json", kSampleIntrinsics);
  std::ifstream in(file(0), std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(in), {}};
  for (const std::string& attribute :
       {std::string("displayWindow\0box2i", 19), std::string("compression\0compression", 23),
        std::string("pixelAspectRatio\0float", 22)}) {
    const std::size_t at = whole.find(attribute + std::string("\0", 1));
    ASSERT_NE(at, std::string::npos) << attribute;
    for (const char length : {'\0', '\x60'}) {
      std::string file_bytes = whole;
      file_bytes[at + attribute.size() + 1] = length;
      std::ofstream(file(0), std::ios::binary | std::ios::trunc) << file_bytes;
      const CopiedCapture capture = read_capture(folder_.path(), "exr-sequence");
      EXPECT_TRUE(std::ranges::any_of(capture.frames, [&](const CopiedFrame& frame) {
        return frame.problem.find(std::string("the attribute ") + attribute.c_str()) != std::string::npos;
      })) << attribute;
    }
  }
}

TEST_F(ExrSequence, WhatIsMissingIsNamed) {
  const auto problem = [&] {
    try {
      read_capture(folder_.path(), "exr-sequence");
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(problem().find("no OpenEXR files"), std::string::npos);
  write_frames();
  EXPECT_NE(problem().find("add intrinsics.json"), std::string::npos) << problem();
  folder_.write("intrinsics.json", kSampleIntrinsics);
  write_exr(file(1), {{"R", 1.0F}, {"G", 1.0F}, {"B", 1.0F}}, kWhole);
  EXPECT_NE(read().frames.at(1).problem.find("a channel Z"), std::string::npos) << read().frames[1].problem;
  write_exr(file(2), {{"R", 1.0F}, {"Z", 1.0F}}, kWhole);
  EXPECT_NE(read().frames.at(2).problem.find("has no colour"), std::string::npos);
}

} // namespace
} // namespace kinora::formats
