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
KinoraStatus reader_next(KinoraReader* /*reader*/, KinoraFrame* /*frame*/, KinoraMessage* /*message*/) {
  return KINORA_END;
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
  behaviour = {true, std::move(change)};
  const KinoraFormat test = format();
  expect_refused(word, [&] { FrameReader(test, "a.test", {}); });
}

TEST(FrameReader, RefusesPluginsThatOpenAFileAndGiveNothing) {
  behaviour = {false, [](KinoraCaptureInfo&) {}};
  const KinoraFormat test = format();
  expect_refused("no reader", [&] { FrameReader(test, "a.test", {}); });
  expect_refused("no writer", [&] { PictureWriter(test, "a.test", {}); });
}

TEST(FrameReader, TakesDescriptionsThatKeepToTheInterface) {
  static const KinoraLabel labels[] = {{2, "box", "rigid"}};
  static const char* const warnings[] = {"dusty lens"};
  behaviour = {true, [](KinoraCaptureInfo& info) {
                 info.labels = labels;
                 info.warnings = warnings;
                 info.label_count = info.warning_count = 1;
               }};
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

TEST(Boundary, NothingThatIsThrownPassesThroughC) {
  auto message = make_struct<KinoraMessage>();
  EXPECT_EQ(formats::guarded(&message, []() -> KinoraStatus { throw 42; }), KINORA_FAILURE); // NOLINT
  EXPECT_STREQ(message.text, "an unknown exception");
}

} // namespace
} // namespace kinora::host
