#include "host/frame_reader.h"

#include <functional>

#include <gtest/gtest.h>

#include "common/boundary.h"
#include "host/interface_struct.h"
#include "host/picture_writer.h"

namespace kinora::host {
namespace {

/// What the plugin of this test does; a plugin's functions have nothing else to remember it by.
struct Behaviour {
  bool gives_handle = true;
  std::function<void(KinoraCaptureInfo&)> change_info = [](KinoraCaptureInfo&) {};
  std::function<void(KinoraFrame&)> change_frame = {}; ///< of one frame; without it there is none
};
Behaviour behaviour; // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)
int handle = 0;

KinoraStatus open_reader(const char* /*path*/, const KinoraOptionValue* /*options*/, size_t /*count*/,
                         KinoraReader** reader, KinoraMessage* /*message*/) {
  if (behaviour.gives_handle) *reader = reinterpret_cast<KinoraReader*>(&handle);
  return KINORA_OK;
}
KinoraStatus reader_info(KinoraReader* /*reader*/, KinoraCaptureInfo* info, KinoraMessage* /*message*/) {
  info->frame_count = 3;
  info->frames_per_second = 30;
  info->camera = {16, 12, 20, 20, 7.5, 5.5, {}, {}};
  behaviour.change_info(*info);
  return KINORA_OK;
}
KinoraStatus reader_next(KinoraReader* /*reader*/, KinoraFrame* frame, KinoraMessage* /*message*/) {
  static const std::uint16_t pixels[17 * 12 * 2] = {};
  if (!behaviour.change_frame) return KINORA_END;
  frame->color = {16, 12, 3, KINORA_PIXEL_U8, 16 * 3, pixels, {}};
  frame->depth = frame->infrared = {16, 12, 1, KINORA_PIXEL_U16, 16 * 2, pixels, {}};
  frame->confidence = frame->labels = {16, 12, 1, KINORA_PIXEL_U8, 16, pixels, {}};
  frame->depth_unit = 0.001;
  behaviour.change_frame(*frame);
  return KINORA_OK;
}
void close_reader(KinoraReader* /*reader*/) {}

KinoraStatus open_writer(const char* /*path*/, const KinoraOptionValue* /*options*/, size_t /*count*/,
                         KinoraWriter** /*writer*/, KinoraMessage* /*message*/) {
  return KINORA_OK; // without one
}

KinoraFormat format() {
  auto format = make_struct<KinoraFormat>();
  format.name = "test";
  format.capabilities = KINORA_READS_FRAMES | KINORA_WRITES_PICTURES;
  format.open_reader = open_reader;
  format.reader_info = reader_info;
  format.reader_next = reader_next;
  format.reader_close = close_reader;
  format.open_writer = open_writer;
  return format;
}

void expect_refused(const std::string& word, const std::function<void()>& call) {
  try {
    call();
    ADD_FAILURE() << "nothing was thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kFailure);
    EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
  }
}

void expect_info_refused(const std::string& word, std::function<void(KinoraCaptureInfo&)> change) {
  behaviour = {true, std::move(change), {}};
  const KinoraFormat test = format();
  expect_refused(word, [&] { FrameReader(test, "a.test", {}); });
}

TEST(FrameReader, RefusesPluginsThatOpenAFileAndGiveNothing) {
  behaviour = {false, [](KinoraCaptureInfo&) {}, {}};
  const KinoraFormat test = format();
  expect_refused("no reader", [&] { FrameReader(test, "a.test", {}); });
  expect_refused("no writer", [&] { PictureWriter(test, "a.test", {}); });
}

TEST(FrameReader, TakesDescriptionsThatKeepToTheInterface) {
  static const KinoraLabel labels[] = {{2, "box", "rigid"}};
  static const char* const warnings[] = {"dusty lens"};
  behaviour = {true,
               [](KinoraCaptureInfo& info) {
                 info.labels = labels;
                 info.warnings = warnings;
                 info.label_count = info.warning_count = 1;
               },
               {}};
  const KinoraFormat test = format();
  EXPECT_EQ(FrameReader(test, "a.test", {}).info().labels[0].label, 2);
}

TEST(FrameReader, RefusesListsThatAreMissing) {
  expect_info_refused("list of labels", [](KinoraCaptureInfo& info) { info.label_count = 1; });
  expect_info_refused("list of warnings", [](KinoraCaptureInfo& info) { info.warning_count = 1; });
}

TEST(FrameReader, RefusesLabelsAndWarningsWithoutText) {
  static const KinoraLabel nameless[] = {{2, nullptr, "rigid"}};
  static const KinoraLabel kindless[] = {{2, "box", nullptr}};
  static const KinoraLabel outside[] = {{256, "box", ""}};
  for (const KinoraLabel* labels : {nameless, kindless, outside}) {
    expect_info_refused("label", [labels](KinoraCaptureInfo& info) {
      info.labels = labels;
      info.label_count = 1;
    });
  }
  static const char* const silent[] = {nullptr};
  expect_info_refused("warning", [](KinoraCaptureInfo& info) {
    info.warnings = silent;
    info.warning_count = 1;
  });
}

TEST(FrameReader, RefusesNumbersThatMakeNoSense) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  expect_info_refused("without frames", [](KinoraCaptureInfo& info) { info.frame_count = 0; });
  expect_info_refused("start time", [](KinoraCaptureInfo& info) { info.start_time = kNan; });
  expect_info_refused("rate", [](KinoraCaptureInfo& info) { info.frames_per_second = 0; });
  expect_info_refused("distortion", [](KinoraCaptureInfo& info) { info.camera.distortion[4] = kNan; });
}

void expect_frame_refused(const std::string& word, std::function<void(KinoraFrame&)> change) {
  behaviour = {true, [](KinoraCaptureInfo&) {}, std::move(change)};
  const KinoraFormat test = format();
  const auto read = FrameReader(test, "a.test", {}).next();
  ASSERT_TRUE(read);
  EXPECT_EQ(read->problem.substr(0, 9), "test gave") << read->problem;
  EXPECT_NE(read->problem.find(word), std::string::npos) << read->problem;
}

TEST(FrameReader, FramesOfAnotherSizeThanTheDescriptionSaysHaveAProblem) {
  expect_frame_refused("no colour", [](KinoraFrame& frame) { frame.color.width = 17; });
  expect_frame_refused("no colour", [](KinoraFrame& frame) { frame.color.row_bytes = 47; });
  expect_frame_refused("no colour", [](KinoraFrame& frame) { frame.color.data = nullptr; });
  expect_frame_refused("no colour", [](KinoraFrame& frame) { frame.color.channels = 4; });
  expect_frame_refused("no depth", [](KinoraFrame& frame) { frame.depth.height = 13; });
  expect_frame_refused("no depth", [](KinoraFrame& frame) { frame.depth.pixel_type = KINORA_PIXEL_U8; });
  expect_frame_refused("infrared", [](KinoraFrame& frame) { frame.infrared.width = 8; });
  expect_frame_refused("confidence", [](KinoraFrame& frame) { frame.confidence.row_bytes = 1; });
  expect_frame_refused("mask", [](KinoraFrame& frame) { frame.labels.height = 0; });
}

TEST(FrameReader, FramesWithNumbersThatMakeNoSenseHaveAProblem) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  expect_frame_refused("unit of depth", [](KinoraFrame& frame) { frame.depth_unit = 0; });
  expect_frame_refused("time", [](KinoraFrame& frame) { frame.time = kNan; });
  expect_frame_refused("pose", [](KinoraFrame& frame) {
    frame.has_pose = 1;
    frame.camera_to_world[7] = kNan;
  });
}

TEST(FrameReader, WhatMayBeAbsentMayBeAbsentAndRowsMayHaveGaps) {
  behaviour = {true, [](KinoraCaptureInfo&) {},
               [](KinoraFrame& frame) {
                 frame.infrared = frame.confidence = frame.labels = {};
                 frame.depth.row_bytes = 34;
               }};
  const KinoraFormat test = format();
  EXPECT_EQ(FrameReader(test, "a.test", {}).next()->problem, "");
}

/// Depth, infrared and confidence are then the depth camera's.
TEST(FrameReader, ADepthCameraOfItsOwnHasASizeOfItsOwn) {
  const auto half = [](KinoraFrame& frame) {
    for (KinoraImage* image : {&frame.depth, &frame.infrared, &frame.confidence}) {
      image->width = 8;
      image->height = 6;
    }
  };
  behaviour = {true,
               [](KinoraCaptureInfo& info) {
                 info.has_depth_camera = 1;
                 info.depth_camera = {8, 6, 10, 10, 3.5, 2.5, {}, {}};
               },
               half};
  const KinoraFormat test = format();
  EXPECT_EQ(FrameReader(test, "a.test", {}).next()->problem, "");
  expect_frame_refused("no depth", half);
}

TEST(Boundary, NothingThatIsThrownPassesThroughC) {
  auto message = make_struct<KinoraMessage>();
  EXPECT_EQ(formats::guarded(&message, []() -> KinoraStatus { throw 42; }), KINORA_FAILURE); // NOLINT
  EXPECT_STREQ(message.text, "an unknown exception");
}

} // namespace
} // namespace kinora::host
