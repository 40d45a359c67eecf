// Words, exit codes and machine output of the commands that need no training.
#include <set>

#include <nlohmann/json.hpp>

#include "cli/run_kinora.h"
#include "clip/clip_io.h"
#include "clip/sample_clip.h"

namespace kinora::test {
namespace {

using Json = nlohmann::json;

class Tool : public testing::Test {
protected:
  Said run(const std::vector<std::string>& words) const { return run_kinora(folder_, words); }
  std::string path(const std::string& name) const { return (folder_.path() / name).string(); }
  std::string sample_clip(const std::string& name = "clip.mkv") const {
    clip::write_clip(clip::testing::sample_clip(1, 5, true), path(name));
    return path(name);
  }

  TemporaryFolder folder_;
};

TEST_F(Tool, HelpOfEveryCommandShowsExamples) {
  EXPECT_EQ(run({"--help"}).code, 0);
  for (const char* command : {"info", "formats", "probe", "encode", "render", "motion", "eval"}) {
    const Said said = run({command, "--help"});
    EXPECT_EQ(said.code, 0);
    EXPECT_NE(said.out.find(std::string("Examples:\n  kinora ") + command), std::string::npos) << said.out;
    EXPECT_EQ(said.err, "");
  }
}

TEST_F(Tool, VersionNamesTheLibraries) {
  const Said said = run({"--version"});
  EXPECT_EQ(said.code, 0);
  for (const char* name : {"kinora ", "libmatroska ", "zstd ", "Eigen "}) {
    EXPECT_NE(said.out.find(name), std::string::npos) << said.out;
  }
}

TEST_F(Tool, StartsWithoutTheLibrariesThatFewCommandsNeed) {
  setenv("LD_TRACE_LOADED_OBJECTS", "1", 1); // the linker lists what it would load, and does no more
  const Said said = run({"--help"});
  unsetenv("LD_TRACE_LOADED_OBJECTS");
  EXPECT_NE(said.out.find("libstdc++"), std::string::npos) << said.out;
  for (const char* library : {"libopencv", "libopenvdb", "libavcodec"}) {
    EXPECT_EQ(said.out.find(library), std::string::npos) << said.out;
  }
}

TEST_F(Tool, AMissingModuleIsNamedWithExitCode6) {
  fs::create_directory(folder_.path() / "bin");
  const std::string program = path("bin/kinora"); // a copy, beside which no modules lie
  fs::copy_file(KINORA_PROGRAM, program);
  const auto run_copy = [&](const std::vector<std::string>& words) {
    return Running(folder_.path(), words, "", program).finish();
  };
  const std::string clip = sample_clip();
  write_numbered(folder_, 3);
  folder_.write("net.onnx", "any");
  expect_error(run_copy({"render", clip, path("film.mp4"), "--size", "32x24"}), 6, "lib/kinora/mp4.so is not there");
  expect_error(run_copy({"convert", clip, path("v.vdb"), "-q"}), 6, "lib/kinora/openvdb.so is not there");
  expect_error(run_copy({"encode", folder_.path(), path("c.mkv"), "--segmenter", path("net.onnx")}), 6,
               "lib/kinora/opencv.so is not there");
  const Said formats = run_copy({"formats"});
  EXPECT_EQ(formats.code, 0) << formats.err;
  EXPECT_NE(formats.out.find("mp4.so is not installed"), std::string::npos) << formats.out;
}

TEST_F(Tool, InfoSaysWhatAFormatBringsThatIsNotUsed) {
  folder_.write("a.world", "flat");
  const std::vector<std::string> words = {"info", path("a.world"), "--plugin-dir",
                                          fs::path(KINORA_EXAMPLE_PLUGIN).parent_path()};
  const Said said = run(words);
  EXPECT_EQ(said.code, 0) << said.err;
  EXPECT_NE(said.out.find("Infrared images, which this format can bring, are not used."), std::string::npos)
      << said.out;
}

TEST_F(Tool, WrongWordsAreUsageErrors) {
  expect_error(run({}), 2, "--help");
  expect_error(run({"dance"}), 2, "--help");
  expect_error(run({"info"}), 2, "kinora info --help");
  expect_error(run({"info", "a", "--loud"}), 2, "--loud");
  expect_error(run({"info", path("nothing")}), 2, "nothing does not exist");
  expect_error(run({"encode", folder_.path(), path("c.mkv"), "--preset", "huge"}), 2, "huge");
  expect_error(run({"encode", folder_.path(), path("c.mkv"), "--holdout", "1"}), 2, "--holdout 1");
  expect_error(run({"encode", folder_.path(), path("c.mkv"), "--frames", "a:b"}), 2, "a:b");
}

TEST_F(Tool, InfoTellsTheClipFirstAndAccountsForEveryByte) {
  const std::string clip = sample_clip();
  const Said text = run({"info", clip});
  EXPECT_EQ(text.code, 0);
  EXPECT_EQ(text.out.find(clip + ": a Kinora clip"), 0U) << text.out;
  const Said machine = run({"info", clip, "--json"});
  const Json info = Json::parse(machine.out);
  EXPECT_EQ(info.at("schema"), "kinora.info/1");
  EXPECT_EQ(info.at("kind"), "clip");
  EXPECT_EQ(info.at("frames"), 5);
  std::size_t bytes = 0;
  for (const Json& part : info.at("parts")) bytes += part.at("bytes").get<std::size_t>();
  EXPECT_EQ(bytes, fs::file_size(clip));
}

TEST_F(Tool, InfoOfACaptureCountsItsFiles) {
  write_numbered(folder_, 3);
  const Said said = run({"info", folder_.path(), "--json"});
  ASSERT_EQ(said.code, 0) << said.err;
  const Json info = Json::parse(said.out);
  EXPECT_EQ(info.at("kind"), "capture");
  EXPECT_EQ(info.at("format"), "numbered-folder");
  EXPECT_EQ(info.at("frames"), 3);
  std::size_t files = 0;
  for (const Json& part : info.at("parts")) files += part.at("files").get<std::size_t>();
  EXPECT_GE(files, 7U);
}

/// All files in one folder, as 7-Scenes has them.
void write_7scenes(const TemporaryFolder& folder) {
  folder.write("camera-intrinsics.txt", "20 0 7.5\n0 20 5.5\n0 0 1\n");
  for (int i = 0; i < 3; ++i) {
    const std::string stem = std::string("frame-").append(six_digits(i));
    folder.write(std::string(stem).append(".color.png"), color_bytes(i));
    folder.write(std::string(stem).append(".depth.png"), depth_bytes(i));
    folder.write(std::string(stem).append(".pose.txt"), "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
  }
}

TEST_F(Tool, InfoOfNumberedFilesSaysTheirPattern) {
  const TemporaryFolder capture;
  write_7scenes(capture);
  capture.write("note1.txt", "the only one with such a name");
  std::set<std::string> names;
  const Json info = Json::parse(run({"info", capture.path(), "--json"}).out);
  for (const Json& part : info.at("parts")) names.insert(part.at("name"));
  EXPECT_EQ(names, (std::set<std::string>{"camera-intrinsics.txt", "frame-*.color.png", "frame-*.depth.png",
                                          "frame-*.pose.txt", "note1.txt"}));
}

/// Whether the camera kept still cannot be seen from a folder without poses.
TEST_F(Tool, InfoSaysIfACaptureHasPoses) {
  write_numbered(folder_, 3);
  EXPECT_NE(run({"info", folder_.path()}).out.find("; without camera poses, without masks\n"), std::string::npos);
  EXPECT_EQ(Json::parse(run({"info", folder_.path(), "--json"}).out).at("has_poses"), false);
  const TemporaryFolder other;
  write_7scenes(other);
  EXPECT_NE(run({"info", other.path()}).out.find("; with camera poses, without masks\n"), std::string::npos);
}

TEST_F(Tool, InfoOfARecordingSpeaksOfInfraredWhereThereIsSome) {
  write_numbered(folder_, 3);
  folder_.write("a.world", "flat");
  const std::string plugins = fs::path(KINORA_EXAMPLE_PLUGIN).parent_path();
  ASSERT_EQ(run({"convert", folder_.path(), path("plain.mkv")}).code, 0);
  ASSERT_EQ(run({"convert", path("a.world"), path("flat.mkv"), "--plugin-dir", plugins}).code, 0);
  EXPECT_EQ(run({"info", path("plain.mkv")}).out.find("nfrared"), std::string::npos);
  EXPECT_NE(run({"info", path("flat.mkv")}).out.find("Infrared images are kept, and not used."), std::string::npos);
}

TEST_F(Tool, FormatsAndProbeSpeakJson) {
  write_numbered(folder_, 3);
  const Json formats = Json::parse(run({"formats", "--json"}).out);
  EXPECT_EQ(formats.at("schema"), "kinora.formats/1");
  EXPECT_GE(formats.at("formats").size(), 5U);
  const Json probe = Json::parse(run({"probe", folder_.path(), "--json"}).out);
  EXPECT_EQ(probe.at("formats").at(0).at("name"), "numbered-folder");
  EXPECT_GT(probe.at("formats").at(0).at("confidence"), 50);
}

TEST_F(Tool, ProbeTellsEveryFormatsScoreAndReason) {
  write_numbered(folder_, 3);
  const Json probe = Json::parse(run({"probe", folder_.path(), "--json"}).out);
  std::set<std::string> told;
  for (const Json& answer : probe.at("formats")) {
    EXPECT_FALSE(answer.at("reason").get<std::string>().empty()) << answer;
    EXPECT_GE(answer.at("confidence"), 0);
    told.insert(answer.at("name"));
  }
  const Json formats = Json::parse(run({"formats", "--json"}).out);
  int readers = 0;
  for (const Json& format : formats.at("formats")) {
    const Json& can = format.at("capabilities");
    if (std::find(can.begin(), can.end(), "read-frames") == can.end()) continue;
    EXPECT_TRUE(told.contains(format.at("name").get<std::string>())) << format.at("name");
    ++readers;
  }
  EXPECT_GE(readers, 18);
}

TEST_F(Tool, ProbeSaysWhichFormatItIsAndWhatIsBroken) {
  folder_.write("a.oni", "NI10 and nothing that could follow");
  const Said said = run({"probe", path("a.oni")});
  EXPECT_NE(said.out.find("It is oni but broken: "), std::string::npos) << said.out;
  const Json probe = Json::parse(run({"probe", path("a.oni"), "--json"}).out);
  EXPECT_NE(probe.at("problem").get<std::string>().find("without pictures"), std::string::npos) << probe;
}

TEST_F(Tool, ProbeNamesAPluginThatCrashesAndGoesOn) {
  write_numbered(folder_, 3);
  const Said said =
      run({"probe", folder_.path(), "--json", "--plugin-dir", fs::path(KINORA_EXAMPLE_PLUGIN_CRASHING).parent_path()});
  ASSERT_EQ(said.code, 0) << said.err;
  const Json formats = Json::parse(said.out).at("formats");
  EXPECT_EQ(formats.at(0).at("name"), "numbered-folder");
  const auto flat = std::find_if(formats.begin(), formats.end(), [](const Json& f) { return f.at("name") == "flat"; });
  ASSERT_NE(flat, formats.end());
  EXPECT_EQ(flat->at("confidence"), 0);
  EXPECT_NE(flat->at("reason").get<std::string>().find("crashed"), std::string::npos) << *flat;
}

TEST_F(Tool, AFileOfAFormatThatIsNotInstalledEndsWithExitCode6) {
  folder_.write("plugins/flat/plugin.json", R"({"name": "flat-world", "version": "1.0", "license": "MIT",
    "abi": [1, 1], "library": "flat.so", "formats": [{"name": "flat", "description": "a flat world",
    "magic": [{"text": "flat"}], "can": ["read-frames"]}]})");
  folder_.write("a.world", "flat and grey");
  for (const char* command : {"probe", "info"})
    expect_error(run({command, path("a.world"), "--plugin-dir", path("plugins")}), 6,
                 "could have been read by the format flat, which is not installed");
}

TEST_F(Tool, ProbeKnowsAClip) {
  const Json probe = Json::parse(run({"probe", sample_clip(), "--json"}).out);
  EXPECT_EQ(probe.at("formats").at(0).at("name"), "kinora-clip");
}

TEST_F(Tool, StrangeInputsAreNotRecognised) {
  folder_.write("text.txt", "hello");
  folder_.write("empty", "");
  fs::create_directory(folder_.path() / "folder");
  for (const char* name : {"text.txt", "empty", "folder"}) {
    expect_error(run({"info", path(name)}), 3, name);
    expect_error(run({"probe", path(name)}), 3, std::string(name) + ": no format recognises it");
    expect_error(run({"encode", path(name), path("c.mkv")}), 3, name);
    expect_error(run({"render", path(name), path("o.png")}), 3, name);
    expect_error(run({"motion", path(name), "--out", path("m.json")}), 3, name);
  }
  EXPECT_FALSE(fs::exists(path("c.mkv.part")));
  EXPECT_FALSE(fs::exists(path("m.json.part")));
}

TEST_F(Tool, CutClipIsCorrupt) {
  const std::string clip = sample_clip();
  fs::resize_file(clip, fs::file_size(clip) / 4); // no field is whole
  expect_error(run({"info", clip}), 4, "clip.mkv");
  expect_error(run({"render", clip, path("o.png")}), 4, "clip.mkv");
}

TEST_F(Tool, ExistingOutputIsReplacedOnlyWhenAsked) {
  const std::string clip = sample_clip();
  folder_.write("m.json", "mine");
  expect_error(run({"motion", clip, "--out", path("m.json")}), 5, "--overwrite");
  EXPECT_EQ(contents_of(path("m.json")), "mine");
  EXPECT_EQ(run({"motion", clip, "--out", path("m.json"), "--overwrite"}).code, 0);
  EXPECT_EQ(Json::parse(contents_of(path("m.json"))).at("layers").size(), 2U);
}

TEST_F(Tool, InputIsNeverItsOwnOutput) {
  const std::string clip = sample_clip();
  const std::string before = contents_of(clip);
  expect_error(run({"motion", clip, "--out", clip, "--overwrite"}), 5, "also the input");
  EXPECT_EQ(contents_of(clip), before);
}

TEST_F(Tool, OutputsThatCannotBeWrittenHaveTheirOwnCode) {
  const std::string clip = sample_clip();
  expect_error(run({"motion", clip, "--out", "/dev/full"}), 5, "/dev/full");
  expect_error(run({"motion", clip, "--out", path("no/folder/m.json")}), 5, "no/folder");
  expect_error(run({"motion", clip, "--out", folder_.path()}), 5, "folder");
  expect_error(run({"render", clip, path("no/o.png"), "--size", "8x8"}), 5, "no");
  expect_error(run({"render", clip, "/dev/full", "--size", "8x8"}), 5, "/dev/full");
  expect_error(Running(folder_.path(), {"info", clip}, "/dev/full").finish(), 5, "stdout");
}

TEST_F(Tool, RigidMotionBeginsAtTheIdentityAndHasTheCamera) {
  clip::Clip clip = clip::testing::sample_clip(1, 5, true);
  std::vector<motion::Motion::Pose> poses = clip.layers[1].motion.poses();
  for (auto& pose : poses) pose.health = motion::Health::kTracked;
  poses[0].health = motion::Health::kLost;
  clip.layers[1].motion = motion::Motion::rigid(poses);
  clip::write_clip(clip, path("clip.mkv"));
  EXPECT_EQ(run({"motion", path("clip.mkv"), "--out", path("m.json"), "-q"}).code, 0);
  const Json motion = Json::parse(contents_of(path("m.json")));
  EXPECT_TRUE(motion.at("fps").is_number());
  const Json& object = motion.at("layers").at(1);
  EXPECT_EQ(object.at("kind"), "rigid");
  EXPECT_EQ(object.at("frames").at(0).at("health"), "lost");
  EXPECT_TRUE(object.at("frames").at(2).contains("camera_to_world"));
  const SE3 expected = poses[3].canonical_to_world * poses[1].canonical_to_world.inverse();
  for (std::size_t r = 0; r < 4; ++r) {
    for (std::size_t c = 0; c < 4; ++c) {
      const Json& frames = object.at("frames");
      EXPECT_NEAR(frames[1]["transform"][r][c].get<double>(), r == c ? 1 : 0, 1e-6);
      EXPECT_NEAR(frames[3]["transform"][r][c].get<double>(),
                  expected.matrix()(static_cast<int>(r), static_cast<int>(c)), 1e-4);
    }
  }
}

TEST_F(Tool, MotionOfADeformingLayerHasItsNodes) {
  const clip::Clip clip = clip::testing::bending_clip(1, 4, true);
  const motion::Motion& walker = clip.layers[2].motion;
  clip::write_clip(clip, path("clip.mkv"));
  EXPECT_EQ(run({"motion", path("clip.mkv"), "--out", path("m.json"), "-q"}).code, 0);
  const Json person = Json::parse(contents_of(path("m.json"))).at("layers").at(2);
  EXPECT_EQ(person.at("name"), "person");
  EXPECT_EQ(person.at("kind"), "deforming");
  ASSERT_EQ(person.at("frames").size(), 4U);
  for (std::size_t f = 0; f < 4; ++f) {
    const Json& frame = person["frames"][f];
    EXPECT_EQ(frame.at("health"), motion::name_of(walker.health(f)));
    EXPECT_TRUE(frame.contains("camera_to_world"));
    EXPECT_FALSE(frame.contains("transform"));
    ASSERT_EQ(frame.at("nodes").size(), walker.graph()->nodes().size());
    for (std::size_t i = 0; i < walker.graph()->nodes().size(); ++i) {
      const SE3 expected = walker.deformations()[f].node_to_world[i].to_se3();
      const auto p = frame["nodes"][i].at("position").get<std::array<double, 3>>();
      const auto q = frame["nodes"][i].at("rotation").get<std::array<double, 4>>();
      // As deformations are rounded (docs/container.md).
      EXPECT_LE((Eigen::Vector3d(p[0], p[1], p[2]) - expected * walker.graph()->nodes()[i]).norm(), 5e-4);
      EXPECT_LE(Eigen::Quaterniond(q[0], q[1], q[2], q[3]).angularDistance(Eigen::Quaterniond(expected.linear())),
                7e-3);
    }
  }
}

TEST_F(Tool, MotionOfAPersonHasItsJoints) {
  clip::Clip clip = clip::testing::bending_clip(1, 4, true);
  const motion::JointPaths& joints = *clip.layers[2].joints;
  clip::write_clip(clip, path("clip.mkv"));
  EXPECT_EQ(run({"motion", path("clip.mkv"), "--out", path("m.json"), "-q"}).code, 0);
  const Json layers = Json::parse(contents_of(path("m.json"))).at("layers");
  EXPECT_FALSE(layers.at(1).at("frames").at(0).contains("joints"));
  for (std::size_t f = 0; f < 4; ++f) {
    const Json& printed = layers.at(2).at("frames").at(f).at("joints");
    ASSERT_EQ(printed.size(), joints.names.size());
    for (std::size_t j = 0; j < joints.names.size(); ++j) {
      EXPECT_EQ(printed[j].at("name"), joints.names[j]);
      const auto p = printed[j].at("position").get<std::array<double, 3>>();
      EXPECT_LE((Eigen::Vector3d(p[0], p[1], p[2]) - joints.positions[f][j]).norm(), 2e-3);
    }
  }
  clip.layers[2].joints.reset();
  clip::write_clip(clip, path("nobody.mkv"));
  EXPECT_EQ(run({"motion", path("nobody.mkv"), "--out", path("n.json"), "-q"}).code, 0);
  EXPECT_FALSE(Json::parse(contents_of(path("n.json")))["layers"][2]["frames"][0].contains("joints"));
}

TEST_F(Tool, InfoOfADeformingLayerCountsItsNodes) {
  const clip::Clip clip = clip::testing::bending_clip(1, 4, true);
  clip::write_clip(clip, path("clip.mkv"));
  const Json info = Json::parse(run({"info", path("clip.mkv"), "--json"}).out);
  EXPECT_EQ(info.at("layers").at(2).at("motion"), "deforming");
  EXPECT_EQ(info.at("layers").at(2).at("nodes"), clip.layers[2].motion.graph()->nodes().size());
  EXPECT_FALSE(info.at("layers").at(1).contains("nodes"));
  EXPECT_NEAR(info.at("bytes_per_frame").get<double>() * 4, static_cast<double>(fs::file_size(path("clip.mkv"))), 2);
  const Said text = run({"info", path("clip.mkv")});
  EXPECT_NE(text.out.find("motion person"), std::string::npos) << text.out;
  EXPECT_NE(text.out.find("per frame"), std::string::npos) << text.out;
}

} // namespace
} // namespace kinora::test
