#include "ingest/capture/capture.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/parallel.h"
#include "formats/sample_capture.h"
#include "host/plugin_table.h"

namespace kinora::ingest {
namespace {

using namespace kinora::test;

class Listener final : public Progress {
public:
  void warn(const std::string& sentence) override { warnings.push_back(sentence); }
  bool cancelled() const override { return stop; }
  std::vector<std::string> warnings;
  bool stop = false;
};

class CaptureTest : public testing::Test {
protected:
  std::unique_ptr<Capture> open(const CaptureOptions& options = {}) {
    return Capture::open(plugins_, folder_.path(), options, listener_);
  }

  std::vector<Frame> read_all(Capture& capture) {
    std::vector<Frame> frames;
    while (auto frame = capture.next()) frames.push_back(std::move(*frame));
    return frames;
  }

  void load_example_plugin() {
    const fs::path folders[] = {fs::path(KINORA_EXAMPLE_PLUGIN).parent_path()};
    host::load_external_plugins(plugins_, folders, listener_);
    listener_.warnings.clear(); // of its broken variants
  }

  /// Opens and reads everything; the error must have this code and its sentence must hold these words.
  void expect_error(ErrorCode code, const std::vector<std::string>& words, const CaptureOptions& options = {}) {
    try {
      read_all(*open(options));
      ADD_FAILURE() << "nothing was thrown";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), code) << error.what();
      for (const std::string& word : words)
        EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
    }
  }

  /// One frame of five is bad for this reason, the others are delivered with their own numbers.
  void expect_frame_2_skipped(const std::string& word) {
    const auto capture = open();
    const std::vector<Frame> frames = read_all(*capture);
    ASSERT_EQ(frames.size(), 4U);
    EXPECT_EQ(frames[2].index, 3);
    ASSERT_EQ(capture->skipped().size(), 1U);
    EXPECT_EQ(capture->skipped()[0].index, 2);
    EXPECT_NE(capture->skipped()[0].reason.find(word), std::string::npos) << capture->skipped()[0].reason;
    ASSERT_FALSE(listener_.warnings.empty());
    EXPECT_NE(listener_.warnings.back().find("frame 2 is skipped"), std::string::npos);
  }

  TemporaryFolder folder_;
  host::PluginTable plugins_ = host::PluginTable::builtin();
  Listener listener_;
};

TEST_F(CaptureTest, DeliversFramesInOrderWithDepthInMetresAndTimesFromZero) {
  write_numbered(folder_, 3);
  const auto capture = open();
  EXPECT_EQ(capture->info().format, "numbered-folder");
  EXPECT_EQ(capture->info().frame_count, 3);
  EXPECT_FALSE(capture->info().has_poses);
  EXPECT_FALSE(capture->info().has_masks);
  const std::vector<Frame> frames = read_all(*capture);
  ASSERT_EQ(frames.size(), 3U);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(frames[i].index, i);
    EXPECT_NEAR(frames[i].time, i / 30.0, 1e-9);
    EXPECT_EQ(frames[i].camera.intrinsics, capture->info().intrinsics);
    EXPECT_FLOAT_EQ(frames[i].depth.at(3, 2), static_cast<float>(1.007 + 0.1 * i));
    EXPECT_EQ(frames[i].depth.at(0, 0), 0);
    EXPECT_TRUE(frames[i].clean_depth.same_size(frames[i].depth));
    EXPECT_TRUE(frames[i].color.same_size(frames[i].depth));
    EXPECT_TRUE(frames[i].labels.empty());
    EXPECT_TRUE(frames[i].camera.camera_to_world.isApprox(SE3::Identity()));
  }
}

TEST_F(CaptureTest, GivesTheSameFramesForOneThreadAndMany) {
  write_numbered(folder_, 4);
  folder_.write("depth/000001.png", "broken");
  const auto digest = [&](int threads) {
    set_thread_count(threads);
    const auto capture = open();
    std::vector<float> values;
    for (const Frame& frame : read_all(*capture)) {
      values.push_back(static_cast<float>(frame.index));
      values.insert(values.end(), frame.clean_depth.values().begin(), frame.clean_depth.values().end());
    }
    set_thread_count(0);
    return values;
  };
  EXPECT_EQ(digest(1), digest(3));
}

TEST_F(CaptureTest, CarriesDepthIntoTheColourCameraThatItIsGiven) {
  write_3dmatch(folder_, 2);
  CaptureOptions options;
  options.registration = {open()->info().intrinsics, open()->info().intrinsics, SE3(Eigen::Translation3d(0, 0, 0.2))};
  options.registration->color.fx = 15;
  const std::vector<Frame> as_given = read_all(*open());
  const auto capture = open(options);
  EXPECT_EQ(capture->info().intrinsics, options.registration->color);
  const std::vector<Frame> frames = read_all(*capture);
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(frames[0].camera.intrinsics, options.registration->color);
  const DepthImage expected = register_depth(as_given[0].depth, *options.registration);
  EXPECT_TRUE(std::equal(expected.values().begin(), expected.values().end(), frames[0].depth.values().begin()));
  // The capture's pose is the depth camera's, 20 cm before the colour camera's.
  const SE3 expected_pose = as_given[1].camera.camera_to_world * options.registration->depth_to_color.inverse();
  EXPECT_TRUE(frames[1].camera.camera_to_world.isApprox(expected_pose));
}

TEST_F(CaptureTest, DepthWithoutConfidenceIsNoMeasurementAndInfraredIsWarnedOfOnce) {
  load_example_plugin();
  folder_.write("a.world", "flat and grey");
  const auto capture = Capture::open(plugins_, folder_.path() / "a.world", {}, listener_);
  const std::vector<Frame> frames = read_all(*capture);
  ASSERT_EQ(frames.size(), 3U);
  for (const Frame& frame : frames) {
    for (int v = 0; v < frame.depth.height(); ++v) {
      for (int u = 0; u < frame.depth.width(); ++u) EXPECT_FLOAT_EQ(frame.depth.at(u, v), u == 0 ? 0.0F : 1.0F);
    }
  }
  const auto of_infrared = [](const std::string& sentence) { return sentence.find("infrared") != std::string::npos; };
  EXPECT_EQ(std::ranges::count_if(listener_.warnings, of_infrared), 1);
}

const KinoraFormat* flat = nullptr; ///< the example plugin's format

KinoraStatus next_with_narrow_confidence(KinoraReader* reader, KinoraFrame* frame, KinoraMessage* message) {
  const KinoraStatus status = flat->reader_next(reader, frame, message);
  --frame->confidence.width;
  return status;
}

TEST_F(CaptureTest, FramesWithConfidenceOfAnotherSizeThanDepthAreBad) {
  load_example_plugin();
  flat = &plugins_.find("flat");
  KinoraFormat narrow = *flat;
  narrow.name = "narrow";
  narrow.reader_next = next_with_narrow_confidence;
  const KinoraFormat* const formats[] = {&narrow};
  plugins_.add({sizeof(KinoraPlugin), KINORA_PLUGIN_ABI, "narrow", "1", formats, 1}, "test");
  CaptureOptions options;
  options.format = "narrow";
  expect_error(ErrorCode::kCorruptInput, {"confidence image", "depth camera's size"}, options);
}

KinoraStatus next_with_overlapping_rows(KinoraReader* reader, KinoraFrame* frame, KinoraMessage* message) {
  const KinoraStatus status = flat->reader_next(reader, frame, message);
  --frame->depth.row_bytes;
  return status;
}

TEST_F(CaptureTest, FramesWhoseRowsOverlapAreBad) {
  load_example_plugin();
  flat = &plugins_.find("flat");
  KinoraFormat overlapping = *flat;
  overlapping.name = "overlapping";
  overlapping.reader_next = next_with_overlapping_rows;
  const KinoraFormat* const formats[] = {&overlapping};
  plugins_.add({sizeof(KinoraPlugin), KINORA_PLUGIN_ABI, "overlapping", "1", formats, 1}, "test");
  CaptureOptions options;
  options.format = "overlapping";
  expect_error(ErrorCode::kCorruptInput, {"depth image", "rows that overlap"}, options);
}

TEST_F(CaptureTest, RefusesCamerasOfAnotherSize) {
  write_3dmatch(folder_, 2);
  CaptureOptions options;
  options.registration = {{8, 6, 20, 20, 3, 2}, {8, 6, 20, 20, 3, 2}, SE3::Identity()};
  expect_error(ErrorCode::kUsage, {"not the capture"}, options);
}

TEST_F(CaptureTest, RangeSelectsFramesThatKeepTheirNumbersAndTimes) {
  write_numbered(folder_, 8);
  CaptureOptions options;
  options.frames = FrameRange::parse("1:7:2");
  const std::vector<Frame> frames = read_all(*open(options));
  ASSERT_EQ(frames.size(), 3U);
  EXPECT_EQ(frames[0].index, 1);
  EXPECT_EQ(frames[2].index, 5);
  EXPECT_NEAR(frames[2].time, 5 / 30.0, 1e-9);
}

TEST_F(CaptureTest, RangeBeyondTheEndIsAnErrorThatCountsTheFrames) {
  write_numbered(folder_, 3);
  CaptureOptions options;
  options.frames = FrameRange::parse("3:");
  expect_error(ErrorCode::kUsage, {"3 frames"}, options);
}

TEST_F(CaptureTest, PosesOfTheCaptureAreUsed) {
  write_3dmatch(folder_, 3);
  const auto capture = open();
  EXPECT_TRUE(capture->info().has_poses);
  const std::vector<Frame> frames = read_all(*capture);
  ASSERT_EQ(frames.size(), 3U);
  EXPECT_NEAR(frames[2].camera.camera_to_world.translation().x(), 0.02, 1e-9);
}

TEST_F(CaptureTest, TumTimesStartAtZero) {
  write_tum(folder_, 3);
  const std::vector<Frame> frames = read_all(*open());
  ASSERT_EQ(frames.size(), 3U);
  EXPECT_NEAR(frames[0].time, 0, 1e-9);
  EXPECT_NEAR(frames[1].time, 1 / 30.0, 1e-5);
}

TEST_F(CaptureTest, MasksBecomeLabelsAndCanBeLeftAside) {
  write_numbered(folder_, 2);
  ColorImage mask(kSampleWidth, kSampleHeight, 1);
  mask.at(4, 4) = 2;
  folder_.write("mask/000000.png", encode_png(mask));
  folder_.write("labels.json", R"({"2": {"name": "anna", "kind": "rigid"}, "3": {}})");
  const auto capture = open();
  EXPECT_TRUE(capture->info().has_masks);
  EXPECT_EQ(capture->info().labels.at(2).name, "anna");
  EXPECT_EQ(capture->info().labels.at(2).kind, "rigid");
  EXPECT_EQ(capture->info().labels.at(3).kind, "");
  const std::vector<Frame> frames = read_all(*capture);
  EXPECT_EQ(frames.at(0).labels.at(4, 4), 2);
  EXPECT_TRUE(frames.at(1).labels.empty());
  CaptureOptions without;
  without.use_masks = false;
  const auto bare = open(without);
  EXPECT_FALSE(bare->info().has_masks);
  EXPECT_TRUE(read_all(*bare).at(0).labels.empty());
}

TEST_F(CaptureTest, FirstOfSeveralMasksGivesAPixelItsLabel) {
  write_numbered(folder_, 1);
  ColorImage first(kSampleWidth, kSampleHeight, 1);
  ColorImage second = first;
  first.at(4, 4) = 3;
  second.at(4, 4) = 2;
  second.at(5, 5) = 2;
  folder_.write("mask/000000_a.png", encode_png(first));
  folder_.write("mask/000000_b.png", encode_png(second));
  const std::vector<Frame> frames = read_all(*open());
  EXPECT_EQ(frames.at(0).labels.at(4, 4), 3);
  EXPECT_EQ(frames.at(0).labels.at(5, 5), 2);
}

// ---- one bad frame among good ones

TEST_F(CaptureTest, MissingImageSkipsItsFrame) {
  write_tum(folder_, 5);
  folder_.remove("rgb/100.066667.png");
  expect_frame_2_skipped("missing");
}

TEST_F(CaptureTest, FrameWithoutPartnerIsSkipped) {
  write_numbered(folder_, 5);
  folder_.remove("depth/000002.png");
  expect_frame_2_skipped("no depth image");
}

TEST_F(CaptureTest, EmptyImageSkipsItsFrame) {
  write_numbered(folder_, 5);
  folder_.write("color/000002.png", "");
  expect_frame_2_skipped("empty");
}

TEST_F(CaptureTest, TruncatedImageSkipsItsFrame) {
  write_numbered(folder_, 5);
  const Bytes whole = depth_bytes(2);
  folder_.write("depth/000002.png", std::span(whole).first(whole.size() / 2));
  expect_frame_2_skipped("depth/000002.png");
}

TEST_F(CaptureTest, TruncatedJpegSkipsItsFrame) {
  write_numbered(folder_, 5);
  const Bytes whole = jpeg_of(sample_color(kSampleWidth, kSampleHeight));
  folder_.write("color/000002.png", std::span(whole).first(whole.size() - 40));
  expect_frame_2_skipped("color/000002.png");
}

TEST_F(CaptureTest, DepthOfTheWrongSizeSkipsItsFrame) {
  write_numbered(folder_, 5);
  folder_.write("depth/000002.png", encode_png16(sample_depth(8, 6)));
  expect_frame_2_skipped("is 8x6, not 16x12");
}

TEST_F(CaptureTest, DepthOfTheWrongTypeSkipsItsFrame) {
  write_numbered(folder_, 5);
  folder_.write("depth/000002.png", encode_png(sample_color(kSampleWidth, kSampleHeight, 1)));
  expect_frame_2_skipped("16-bit");
}

TEST_F(CaptureTest, DepthWithoutAnyMeasurementSkipsItsFrame) {
  write_numbered(folder_, 5);
  folder_.write("depth/000002.png", encode_png16(DepthImage16(kSampleWidth, kSampleHeight)));
  expect_frame_2_skipped("no measurement");
}

TEST_F(CaptureTest, DepthInAWrongUnitIsSaidToBeSo) {
  write_numbered(folder_, 5);
  DepthImage16 depth(kSampleWidth, kSampleHeight);
  for (std::uint16_t& z : depth.values()) z = 50'000; // 50 m
  folder_.write("depth/000002.png", encode_png16(depth));
  expect_frame_2_skipped("wrong unit of depth");
}

TEST_F(CaptureTest, MaskOfTheWrongSizeSkipsItsFrame) {
  write_numbered(folder_, 5);
  folder_.write("mask/000002.png", encode_png(sample_color(8, 6, 1)));
  expect_frame_2_skipped("is 8x6, not 16x12");
}

TEST_F(CaptureTest, PoseThatIsNotFiniteSkipsItsFrame) {
  for (const char* value : {"nan", "-inf", "0"}) {
    listener_.warnings.clear();
    write_3dmatch(folder_, 5);
    std::string pose;
    for (int i = 0; i < 16; ++i) pose += std::string(value) + " ";
    folder_.write("frames/frame-000152.pose.txt", pose);
    expect_frame_2_skipped("frame-000152.pose.txt");
  }
}

TEST_F(CaptureTest, BadFirstFrameIsSkippedToo) {
  write_numbered(folder_, 5);
  folder_.write("color/000000.png", "");
  const std::vector<Frame> frames = read_all(*open());
  ASSERT_EQ(frames.size(), 4U);
  EXPECT_EQ(frames[0].index, 1);
  EXPECT_NEAR(frames[0].time, 1 / 30.0, 1e-9);
}

TEST_F(CaptureTest, FramesOutOfOrderAreWarnedOfAndSorted) {
  write_tum(folder_, 3);
  folder_.write("rgb.txt",
                "100.033333 rgb/100.033333.png\n100.000000 rgb/100.000000.png\n100.066667 rgb/100.066667.png\n");
  const std::vector<Frame> frames = read_all(*open());
  ASSERT_EQ(frames.size(), 3U);
  EXPECT_LT(frames[0].time, frames[1].time);
  ASSERT_EQ(listener_.warnings.size(), 1U);
  EXPECT_NE(listener_.warnings[0].find("out of order"), std::string::npos);
}

// ---- captures that cannot be used

TEST_F(CaptureTest, MoreThanHalfOfTheFramesBadIsAnErrorWithTheFirstReason) {
  write_numbered(folder_, 5);
  for (int i = 2; i < 5; ++i) folder_.write("color/" + six_digits(i) + ".png", "");
  expect_error(ErrorCode::kCorruptInput, {"3 of 5 frames", "000002.png", "empty"});
}

TEST_F(CaptureTest, NoReadableFrameIsAnError) {
  write_numbered(folder_, 3);
  for (int i = 0; i < 3; ++i) folder_.write("depth/" + six_digits(i) + ".png", "");
  expect_error(ErrorCode::kCorruptInput, {"depth/000000.png", "no frame of this capture can be read"});
}

TEST_F(CaptureTest, AbsentIntrinsicsAreAnErrorThatSaysWhatToAdd) {
  write_numbered(folder_, 3);
  folder_.remove("intrinsics.json");
  expect_error(ErrorCode::kCorruptInput, {folder_.path().string(), "add intrinsics.json"});
}

TEST_F(CaptureTest, AbsurdIntrinsicsAreAnErrorThatNamesTheFile) {
  write_numbered(folder_, 3);
  folder_.write("intrinsics.json", R"({"fx": 1e7, "fy": 20, "cx": 7.5, "cy": 5.5})");
  expect_error(ErrorCode::kCorruptInput, {"intrinsics.json", "absurd"});
}

TEST_F(CaptureTest, IntrinsicsForAnotherSizeAreAnError) {
  write_numbered(folder_, 3);
  folder_.write("intrinsics.json", R"({"width": 32, "height": 24, "fx": 40, "fy": 40, "cx": 15.5, "cy": 11.5})");
  expect_error(ErrorCode::kCorruptInput, {"intrinsics.json", "32x24", "16x12"});
}

TEST_F(CaptureTest, DepthThatIsNotRegisteredToColorIsRefused) {
  write_numbered(folder_, 3);
  for (int i = 0; i < 3; ++i) folder_.write("depth/" + six_digits(i) + ".png", encode_png16(sample_depth(14, 10)));
  expect_error(ErrorCode::kCorruptInput, {"14x10", "16x12", "register"});
}

TEST_F(CaptureTest, DamagedLabelsAreAnErrorThatShowsTheirForm) {
  write_numbered(folder_, 1);
  for (const char* text : {"{", "[]", R"({"x": {}})", R"({"300": {}})", R"({"1": 5})", R"({"1": {"name": 5}})",
                           R"({"1": {"kind": "liquid"}})"}) {
    folder_.write("labels.json", text);
    expect_error(ErrorCode::kCorruptInput, {"labels.json", "deforming|rigid|still"});
  }
}

TEST_F(CaptureTest, FolderThatIsNoCaptureIsNotRecognised) {
  folder_.write("notes.txt", "nothing to see");
  expect_error(ErrorCode::kNotRecognised, {folder_.path().string(), "no format recognises it"});
}

TEST_F(CaptureTest, ColorWithoutDepthIsNotRecognisedButExplained) {
  write_numbered(folder_, 2);
  folder_.remove("depth");
  expect_error(ErrorCode::kNotRecognised, {"numbered-folder", "without a folder depth/"});
}

TEST_F(CaptureTest, PathThatDoesNotExistIsAUsageError) {
  try {
    Capture::open(plugins_, folder_.path() / "absent", {}, listener_);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kUsage);
  }
}

TEST_F(CaptureTest, FormatCanBeGivenByName) {
  write_tum(folder_, 2);
  write_numbered(folder_, 2);
  CaptureOptions options;
  options.format = "numbered-folder";
  EXPECT_EQ(open(options)->info().format, "numbered-folder");
  EXPECT_EQ(open()->info().format, "tum-rgbd");
  options.format = "3dmatch";
  expect_error(ErrorCode::kNotRecognised, {"not a 3DMatch folder"}, options);
  options.format = "magic";
  expect_error(ErrorCode::kUsage, {"no format is called \"magic\"", "tum-rgbd"}, options);
  options.format = "png";
  expect_error(ErrorCode::kUsage, {"cannot be read"}, options);
}

TEST_F(CaptureTest, CancellingEndsInAnError) {
  write_numbered(folder_, 3);
  const auto capture = open();
  ASSERT_TRUE(capture->next());
  listener_.stop = true;
  try {
    capture->next();
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInterrupted);
  }
}

TEST_F(CaptureTest, DepthBeyondAnySensorIsNoMeasurement) {
  write_numbered(folder_, 1);
  DepthImage16 depth = sample_depth(kSampleWidth, kSampleHeight);
  depth.at(5, 5) = 65535;
  folder_.write("depth/000000.png", encode_png16(depth));
  EXPECT_EQ(read_all(*open()).at(0).depth.at(5, 5), 0);
}

} // namespace
} // namespace kinora::ingest
