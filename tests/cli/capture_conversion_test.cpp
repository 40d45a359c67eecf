// kinora convert between captures, as a user runs it: what goes round comes back.
#include <algorithm>
#include <set>

#include <nlohmann/json.hpp>

#include "cli/known_formats.h"
#include "cli/run_kinora.h"
#include "formats/capture_frames.h"
#include "record/recorder.h"

namespace kinora::test {
namespace {

constexpr int kFrames = 3;

// ---- captures to begin with

void make_numbered(const TemporaryFolder& folder) {
  write_numbered(folder, kFrames);
  for (int i = 0; i < kFrames; ++i) {
    ColorImage mask(kSampleWidth, kSampleHeight, 1);
    mask.at(i, 1) = 1;
    mask.at(i, 2) = 3;
    folder.write("mask/" + six_digits(i) + ".png", encode_png(mask));
  }
  folder.write("labels.json", R"({"3": {"name": "anna", "kind": "deforming"}})");
}

void make_tum(const TemporaryFolder& folder) {
  write_tum(folder, kFrames);
  folder.write("groundtruth.txt",
               "99.95 0 0 0 0 0 0 1\n100.04 0.123456789 0 1 0 0.6 0 0.8\n100.12 3 0 1 0 0.6 0 0.8\n");
}

void make_3dmatch(const TemporaryFolder& folder) { write_3dmatch(folder, kFrames); }

void make_jpeg(const TemporaryFolder& folder) {
  folder.write("intrinsics.json", R"({"width": 16, "height": 12, "fx": 20.1, "fy": 20.3, "cx": 7.7, "cy": 5.3,
    "depth_factor": 5000, "fps": 25, "distortion": [0.1, -0.05, 0.001, 0.002, 0.01]})");
  for (int i = 0; i < kFrames; ++i) {
    folder.write("color/" + six_digits(i) + ".jpg", jpeg_of(sample_color(kSampleWidth, kSampleHeight, 3, i)));
    folder.write("depth/" + six_digits(i) + ".png", depth_bytes(i));
  }
}

/// Two cameras, infrared, confidence, poses, and times that no rate explains.
void make_recording(const TemporaryFolder& folder) {
  recording::Description description;
  description.start_time = 7.5;
  description.camera = {kSampleWidth, kSampleHeight, 20, 21, 7.5, 5.5, {0.1, 0, 0, 0, 0}, {}};
  description.depth_camera = KinoraCamera{8, 6, 10, 11, 3.5, 2.5, {}, {}};
  description.depth_to_color = {1, 0, 0, 0.05, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  description.has_poses = true;
  std::optional<record::Recorder> recorder;
  for (int i = 0; i < kFrames; ++i) {
    const ColorImage color = sample_color(kSampleWidth, kSampleHeight, 3, i);
    const DepthImage16 depth = sample_depth(8, 6, static_cast<std::uint16_t>(900 + i));
    const DepthImage16 infrared = sample_depth(8, 6, static_cast<std::uint16_t>(20 + i));
    const LabelImage confidence(8, 6, 1, static_cast<std::uint8_t>(i));
    KinoraFrame frame{};
    frame.struct_size = sizeof frame;
    frame.index = i;
    frame.time = 7.5 + 0.1 * i * i;
    frame.depth_unit = 0.00025;
    frame.color = {kSampleWidth, kSampleHeight, 3, KINORA_PIXEL_U8, 3 * kSampleWidth, color.data(), {}};
    frame.depth = {8, 6, 1, KINORA_PIXEL_U16, 16, depth.data(), {}};
    frame.infrared = {8, 6, 1, KINORA_PIXEL_U16, 16, infrared.data(), {}};
    frame.confidence = {8, 6, 1, KINORA_PIXEL_U8, 8, confidence.data(), {}};
    frame.has_pose = 1;
    const double pose[16] = {1, 0, 0, 0.3 * i, 0, 0.8, -0.6, 0, 0, 0.6, 0.8, 1, 0, 0, 0, 1};
    std::copy(std::begin(pose), std::end(pose), frame.camera_to_world);
    if (!recorder) recorder.emplace(folder.path() / "r.mkv", description, frame);
    ASSERT_TRUE(recorder->write(frame));
  }
  recorder->finish();
}

/// One camera whose frames have everything that can be beside colour and depth.
void make_rich(const TemporaryFolder& folder) {
  recording::Description description;
  description.start_time = 3;
  description.frames_per_second = 24;
  description.camera = {kSampleWidth, kSampleHeight, 20, 21, 7.3, 5.1, {}, {}};
  description.has_poses = true;
  description.has_masks = true;
  description.labels = {{1, "anna", "deforming"}, {2, "box", ""}};
  std::optional<record::Recorder> recorder;
  for (int i = 0; i < kFrames; ++i) {
    const ColorImage color = sample_color(kSampleWidth, kSampleHeight, 3, i);
    DepthImage16 depth = sample_depth(kSampleWidth, kSampleHeight, static_cast<std::uint16_t>(900 + i));
    depth.at(1, 1) = 65535;
    depth.at(2, 1) = 1;
    depth.at(3, 1) = 0;
    const DepthImage16 infrared = sample_depth(kSampleWidth, kSampleHeight, static_cast<std::uint16_t>(20 + i));
    LabelImage confidence(kSampleWidth, kSampleHeight, 1);
    for (std::size_t k = 0; k < confidence.pixel_count(); ++k) confidence.data()[k] = static_cast<std::uint8_t>(k + 70);
    const LabelImage labels(kSampleWidth, kSampleHeight, 1, static_cast<std::uint8_t>(i));
    KinoraFrame frame{};
    frame.struct_size = sizeof frame;
    frame.index = i;
    frame.time = 3 + 1 / 24.0 * i + 1e-3 * i * i;
    frame.depth_unit = 0.0002;
    frame.color = {kSampleWidth, kSampleHeight, 3, KINORA_PIXEL_U8, 3 * kSampleWidth, color.data(), {}};
    frame.depth = {kSampleWidth, kSampleHeight, 1, KINORA_PIXEL_U16, 2 * kSampleWidth, depth.data(), {}};
    frame.infrared = {kSampleWidth, kSampleHeight, 1, KINORA_PIXEL_U16, 2 * kSampleWidth, infrared.data(), {}};
    frame.confidence = {kSampleWidth, kSampleHeight, 1, KINORA_PIXEL_U8, kSampleWidth, confidence.data(), {}};
    frame.labels = {kSampleWidth, kSampleHeight, 1, KINORA_PIXEL_U8, kSampleWidth, labels.data(), {}};
    frame.has_pose = 1;
    const double pose[16] = {1, 0, 0, 0.3 * i, 0, 0.8, -0.6, 0, 0, 0.6, 0.8, 1, 0, 0, 0, 1};
    std::copy(std::begin(pose), std::end(pose), frame.camera_to_world);
    if (!recorder) recorder.emplace(folder.path() / "r.mkv", description, frame);
    ASSERT_TRUE(recorder->write(frame));
  }
  recorder->finish();
}

struct Source {
  const char* name;
  void (*make)(const TemporaryFolder& folder);
  const char* path; ///< in the folder
};
constexpr Source kSources[] = {{"numbered_with_masks", make_numbered, ""},
                               {"tum_with_poses", make_tum, ""},
                               {"three_d_match", make_3dmatch, ""},
                               {"jpeg_with_distortion", make_jpeg, ""},
                               {"everything_of_one_camera", make_rich, "r.mkv"},
                               {"recording_of_two_cameras", make_recording, "r.mkv"}};

/// What a target keeps besides colour, depth and calibration.
struct Target {
  const char* format;
  const char* output;
  bool times, poses, masks, images; ///< images: infrared and confidence
  bool jpeg;                        ///< the file of colour, not its pixels alone
  bool two_cameras;
};
constexpr Target kTargets[] = {{"tum-rgbd", "out", true, true, true, false, true, false},
                               {"numbered-folder", "out", false, false, true, false, true, false},
                               {"transforms", "out", true, true, false, false, true, false},
                               {"exr-sequence", "out", true, true, true, true, false, false},
                               {"kinora-recording", "out.mkv", true, true, true, true, true, true}};

void expect_same_camera(const KinoraCamera& a, const KinoraCamera& b) {
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  EXPECT_DOUBLE_EQ(a.fx, b.fx);
  EXPECT_DOUBLE_EQ(a.fy, b.fy);
  EXPECT_NEAR(a.cx, b.cx, 1e-12);
  EXPECT_NEAR(a.cy, b.cy, 1e-12);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(a.distortion[i], b.distortion[i]);
}

void expect_same(const CopiedCapture& before, const CopiedCapture& after, const Target& target) {
  expect_same_camera(before.info.camera, after.info.camera);
  EXPECT_DOUBLE_EQ(before.info.frames_per_second, after.info.frames_per_second);
  EXPECT_EQ(before.info.has_depth_camera, after.info.has_depth_camera);
  ASSERT_EQ(before.frames.size(), after.frames.size());
  for (std::size_t i = 0; i < before.frames.size(); ++i) {
    const CopiedFrame& a = before.frames[i];
    const CopiedFrame& b = after.frames[i];
    EXPECT_EQ(b.problem, "");
    EXPECT_EQ(a.color, b.color);
    if (target.jpeg) {
      EXPECT_EQ(a.jpeg, b.jpeg);
    }
    EXPECT_EQ(a.depth, b.depth);
    EXPECT_EQ(a.depth_unit, b.depth_unit);
    if (target.times) {
      EXPECT_NEAR(a.time - before.frames[0].time, b.time - after.frames[0].time, 1e-9);
    }
    if (target.poses && a.has_pose) {
      for (std::size_t k = 0; k < 16; ++k) EXPECT_NEAR(a.pose[k], b.pose[k], 1e-12);
    }
    if (target.masks) {
      EXPECT_EQ(a.labels, b.labels);
    }
    if (!target.images) continue;
    EXPECT_EQ(a.time, b.time);
    EXPECT_EQ(a.infrared, b.infrared);
    EXPECT_EQ(a.confidence, b.confidence);
  }
}

class RoundTrip : public testing::TestWithParam<std::tuple<Source, Target>> {};

TEST_P(RoundTrip, KeepsEveryBitThatTheTargetHasAPlaceFor) {
  const auto& [source, target] = GetParam();
  const TemporaryFolder from;
  const TemporaryFolder to;
  source.make(from);
  const fs::path input = from.path() / source.path;
  const fs::path output = to.path() / target.output;
  const CopiedCapture before = read_capture(input);
  std::vector<std::string> words = {"convert", input.string(), output.string(), "--to", target.format};
  if (std::string(target.format) == "transforms") words.insert(words.end(), {"-O", "still=true"});
  const Said said = run_kinora(to, words);
  if (before.info.has_depth_camera != 0 && !target.two_cameras) {
    expect_error(said, 1, "camera of its own");
    EXPECT_FALSE(fs::exists(output));
    return;
  }
  ASSERT_EQ(said.code, 0) << said.err;
  const CopiedCapture after = read_capture(output);
  EXPECT_EQ(after.format, target.format);
  expect_same(before, after, target);
}

INSTANTIATE_TEST_SUITE_P(All, RoundTrip, testing::Combine(testing::ValuesIn(kSources), testing::ValuesIn(kTargets)),
                         [](const auto& chosen) {
                           std::string name = std::get<0>(chosen.param).name;
                           name += "_to_" + std::string(std::get<1>(chosen.param).format);
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

/// A new one comes among the targets, and is compared then.
TEST(RoundTrips, AreOfEveryFormatThatReadsAndWritesCaptures) {
  const TemporaryFolder folder;
  std::set<std::string> compared;
  for (const Target& target : kTargets) compared.insert(target.format);
  const std::set<std::string> written = formats_with_any(folder, {"write-frames"});
  EXPECT_EQ(compared, written);
  EXPECT_TRUE(std::ranges::includes(formats_with_any(folder, {"read-frames"}), written)) << "what reads one again?";
}

std::vector<std::string> words_for(const Target& target, const fs::path& from, const fs::path& to) {
  std::vector<std::string> words = {"convert", from.string(), (to / target.output).string(), "--to", target.format};
  if (std::string(target.format) == "transforms") words.insert(words.end(), {"-O", "still=true"});
  return words;
}

class EachTarget : public testing::TestWithParam<Target> {
protected:
  TemporaryFolder from_;
  TemporaryFolder to_;
  TemporaryFolder out_;
};

class CaptureConversion : public testing::Test {
protected:
  CaptureConversion() { make_tum(from_); }
  Said convert(const std::string& output, std::vector<std::string> more = {}) {
    std::vector<std::string> words = {"convert", from_.path().string(), (to_.path() / output).string()};
    words.insert(words.end(), more.begin(), more.end());
    return run_kinora(to_, words);
  }
  bool exists(const std::string& name) const { return fs::exists(to_.path() / name); }

  TemporaryFolder from_;
  TemporaryFolder to_;
};

TEST_F(CaptureConversion, TheNameSaysTheFormat) {
  ASSERT_EQ(convert("a.mkv").code, 0);
  EXPECT_EQ(read_capture(to_.path() / "a.mkv").format, "kinora-recording");
  ASSERT_EQ(convert("a").code, 0);
  EXPECT_EQ(read_capture(to_.path() / "a").format, "tum-rgbd");
}

TEST_F(CaptureConversion, WhatIsLostIsSaidAndStrictRefusesIt) {
  const Said said = convert("a", {"--to", "numbered-folder"});
  EXPECT_EQ(said.code, 0);
  EXPECT_NE(said.err.find("camera poses"), std::string::npos) << said.err;
  expect_error(convert("b", {"--to", "numbered-folder", "--strict"}), 1, "--strict");
  EXPECT_FALSE(exists("b"));
  EXPECT_FALSE(exists("b.part"));
}

TEST_F(CaptureConversion, DryRunWritesNothing) {
  const Said said = convert("a", {"--dry-run", "--json", "--frames", "1:"});
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_EQ(nlohmann::json::parse(said.out)["frames"], kFrames - 1);
  EXPECT_FALSE(exists("a"));
}

TEST_F(CaptureConversion, FramesOfTheRangeAloneAreWritten) {
  ASSERT_EQ(convert("a.mkv", {"--frames", "0:3:2"}).code, 0);
  const CopiedCapture before = read_capture(from_.path());
  const CopiedCapture after = read_capture(to_.path() / "a.mkv");
  ASSERT_EQ(after.frames.size(), 2U);
  EXPECT_EQ(after.frames[1].depth, before.frames[2].depth);
}

TEST_F(CaptureConversion, ARangeWithoutFramesIsAUsageError) {
  expect_error(convert("a.mkv", {"--frames", "3:9"}), 2, "has 3 frames");
  expect_error(convert("a.mkv", {"--frames", "3:9", "--dry-run"}), 2, "has 3 frames");
}

TEST_F(CaptureConversion, ABadFrameIsNamedAndTheOthersAreWritten) {
  from_.write("depth/100.038333.png", "no picture");
  const Said said = convert("a", {"--json"});
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_EQ(nlohmann::json::parse(said.out)["problems"].size(), 1U);
  EXPECT_EQ(read_capture(to_.path() / "a").frames.size(), static_cast<std::size_t>(kFrames - 1));
  expect_error(convert("b", {"--strict"}), 4, "100.038333.png");
  EXPECT_FALSE(exists("b"));
  EXPECT_FALSE(exists("b.part"));
}

TEST_P(EachTarget, LeavesNothingWhenInterrupted) {
  constexpr int kMany = 200;
  constexpr int kWidth = 640, kHeight = 480;
  from_.write("intrinsics.json", R"({"fx": 500, "fy": 500, "cx": 319.5, "cy": 239.5})");
  const auto color = encode_png(sample_color(kWidth, kHeight, 3));
  const auto depth = encode_png16(sample_depth(kWidth, kHeight, 1000));
  for (int i = 0; i < kMany; ++i) {
    from_.write("color/" + six_digits(i) + ".png", color);
    from_.write("depth/" + six_digits(i) + ".png", depth);
  }
  Running running(out_.path(), words_for(GetParam(), from_.path(), to_.path()));
  ASSERT_TRUE(running.wait_for("converting"));
  running.interrupt();
  expect_error(running.finish(), 130, "interrupted");
  EXPECT_TRUE(fs::is_empty(to_.path())) << "neither the output nor what would have become it";
}

/// The largest file that a program may write stands for a disk that is full.
TEST_P(EachTarget, LeavesNothingOnAFullDisk) {
  from_.write("intrinsics.json", R"({"fx": 100, "fy": 100, "cx": 79.5, "cy": 59.5})");
  from_.write("color/0.png", encode_png(sample_color(160, 120, 3)));
  from_.write("depth/0.png", encode_png16(sample_depth(160, 120, 1000)));
  std::vector<std::string> words = words_for(GetParam(), from_.path(), to_.path());
  words.insert(words.begin(), {"-c", R"(trap "" XFSZ; ulimit -f 1; exec "$0" "$@")", KINORA_PROGRAM});
  expect_error(Running(out_.path(), words, {}, "/bin/bash").finish(), 5, "cannot be written");
  EXPECT_TRUE(fs::is_empty(to_.path()));
}

TEST_P(EachTarget, TakesNamesOfAllLanguages) {
  make_numbered(from_);
  const fs::path place = to_.path() / "Ordner für 'Bilder' 日本";
  fs::create_directories(place);
  const Said said = run_kinora(out_, words_for(GetParam(), from_.path(), place));
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_EQ(read_capture(place / GetParam().output).frames.size(), static_cast<std::size_t>(kFrames));
}

TEST_P(EachTarget, RefusesAnOptionThatDoesNotExist) {
  make_numbered(from_);
  std::vector<std::string> words = words_for(GetParam(), from_.path(), to_.path());
  words.insert(words.end(), {"-O", "sitll=true"});
  expect_error(run_kinora(out_, words), 2, "no option \"sitll\"");
  EXPECT_TRUE(fs::is_empty(to_.path()));
}

INSTANTIATE_TEST_SUITE_P(All, EachTarget, testing::ValuesIn(kTargets), [](const auto& chosen) {
  std::string name = chosen.param.format;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
});

TEST_F(CaptureConversion, NothingIsReplacedUnasked) {
  ASSERT_EQ(convert("a").code, 0);
  expect_error(convert("a", {"--overwrite"}), 5, "never replaced");
  ASSERT_EQ(convert("a.mkv").code, 0);
  expect_error(convert("a.mkv"), 5, "--overwrite");
  EXPECT_EQ(convert("a.mkv", {"--overwrite"}).code, 0);
}

TEST_F(CaptureConversion, DataSetsWithoutPosesAreRefusedUnlessTheCameraKeptStill) {
  from_.remove("groundtruth.txt");
  expect_error(convert("a", {"--to", "transforms"}), 2, "still=true");
  EXPECT_FALSE(exists("a"));
  ASSERT_EQ(convert("a", {"--to", "transforms", "-O", "still=true"}).code, 0);
  EXPECT_EQ(read_capture(to_.path() / "a").format, "transforms");
}

TEST_F(CaptureConversion, WhereNothingCanBeWrittenItSaysSo) {
  expect_error(run_kinora(to_, {"convert", from_.path().string(), "/proc/a.mkv"}), 5, "/proc/a.mkv");
  expect_error(run_kinora(to_, {"convert", from_.path().string(), "/proc/a"}), 5, "/proc/a");
}

} // namespace
} // namespace kinora::test
