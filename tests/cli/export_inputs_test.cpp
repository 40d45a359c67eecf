// What every door out does with clips, names and places that are not as usual, as a user runs it.
#include <functional>
#include <map>
#include <set>

#include "bake/analytic_field.h"
#include "cli/known_formats.h"
#include "cli/run_kinora.h"
#include "clip/clip_io.h"

namespace kinora::test {
namespace {

/// A command that writes a clip in one format.
struct Door {
  std::string format;
  std::vector<std::string> words; ///< before the clip, the output and after them
  std::string output;
  std::vector<std::string> options;
  std::string first; ///< the file that is there afterwards, first if there are several
  std::string stage; ///< that it tells of when the work begins
};

const Door kDoors[] = {
    {"glb", {"convert"}, "clip.glb", {"-O", "triangles=2000"}, "clip.glb", "surfaces"},
    {"glb",
     {"convert"},
     "sequence.glb",
     {"-O", "animation=sequence", "-O", "compression=draco", "-O", "triangles=2000"},
     "sequence.glb",
     "surfaces"},
    {"usd", {"convert"}, "clip.usda", {"-O", "triangles=2000"}, "clip.usda", "surfaces"},
    {"ply", {"convert"}, "clip.ply", {"-O", "triangles=2000"}, "clip_0001.ply", "surfaces"},
    {"ply", {"convert"}, "splats.ply", {"-O", "content=splats", "-O", "triangles=2000"}, "splats_0001.ply", "surfaces"},
    {"obj", {"convert"}, "clip.obj", {"-O", "triangles=2000"}, "clip_0001.obj", "surfaces"},
    {"openvdb",
     {"convert"},
     "clip.vdb",
     {"-O", "voxel=0.05", "-O", "content=both", "-O", "index=true"},
     "clip_0001.vdb",
     "volumes"},
    {"png", {"render"}, "pictures", {"--size", "160x120"}, "pictures/000000.png", "drawing"},
    {"exr", {"render"}, "pictures", {"--size", "160x120", "-O", "format=exr"}, "pictures/000000.exr", "drawing"},
    {"exr",
     {"render"},
     "views",
     {"--size", "160x120", "-O", "format=exr", "-O", "views=parts", "--passes", "rgb,deep"},
     "views/000000.exr",
     "drawing"},
    {"mp4", {"render"}, "film.mp4", {"--size", "160x120"}, "film.mp4", "drawing"},
    {"mp4", {"render"}, "film.webm", {"--size", "160x120"}, "film.webm", "drawing"},
    {"data-set", {"render"}, "set", {"--size", "160x120", "-O", "format=data-set"}, "set/transforms.json", "drawing"},
};

class Exports : public testing::Test {
protected:
  Exports() { write(bake::testing::sample_clip(kFrames)); }

  void write(const clip::Clip& clip) const {
    fs::remove(path("clip.mkv"));
    clip::write_clip(clip, path("clip.mkv"));
  }
  fs::path path(const std::string& name) const { return folder_.path() / name; }
  std::vector<std::string> words_of(const Door& door, const std::string& into,
                                    const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words = door.words;
    words.push_back(path("clip.mkv").string());
    words.push_back(path(into + door.output).string());
    words.insert(words.end(), door.options.begin(), door.options.end());
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  Said run(const Door& door, const std::string& into, const std::vector<std::string>& more = {}) const {
    return run_kinora(folder_, words_of(door, into, more));
  }
  std::vector<std::string> unfinished() const {
    std::vector<std::string> names;
    for (const std::string& name : names_in(folder_.path()))
      if (name.find(".part") != std::string::npos) names.push_back(name);
    return names;
  }
  /// Each door into a folder of its own.
  void expect_all_written(const std::string& folder) const {
    int number = 0;
    for (const Door& door : kDoors) {
      const std::string into = folder + std::to_string(++number) + "/";
      fs::create_directories(path(into));
      const Said said = run(door, into);
      EXPECT_EQ(said.code, 0) << door.first << ": " << said.err;
      EXPECT_TRUE(fs::exists(path(into + door.first))) << into + door.first;
      EXPECT_GT(fs::file_size(path(into + door.first)), 100U) << into + door.first;
    }
    EXPECT_TRUE(unfinished().empty());
  }

  static constexpr int kFrames = 3;
  TemporaryFolder folder_;
};

TEST_F(Exports, ClipsNeedNotHoldEveryKindOfLayer) {
  const std::pair<const char*, std::function<void(clip::Clip&)>> kinds[] = {
      {"no object", [](clip::Clip& c) { c.layers.erase(c.layers.begin() + 1); }},
      {"nothing deforms", [](clip::Clip& c) { c.layers.pop_back(); }},
      {"a room alone", [](clip::Clip& c) { c.layers.resize(1); }},
      {"a person alone", [](clip::Clip& c) { c.layers.erase(c.layers.begin(), c.layers.begin() + 2); }}};
  for (const auto& [name, change] : kinds) {
    clip::Clip clip = bake::testing::sample_clip(kFrames);
    change(clip);
    write(clip);
    expect_all_written(name);
  }
}

TEST_F(Exports, OneFrameIsEnough) {
  write(bake::testing::sample_clip(1));
  expect_all_written("one");
}

TEST_F(Exports, WhereNothingIsThereMeshesAreRefusedAndTheRestIsEmpty) {
  clip::Clip clip = bake::testing::sample_clip(kFrames);
  for (clip::Layer& layer : clip.layers) layer.field = fields::Field(bake::testing::unit_config());
  write(clip);
  for (const Door& door : kDoors) {
    const Said said = run(door, "");
    if (door.stage == "surfaces") {
      expect_error(said, 1, "no layer has a surface");
      EXPECT_FALSE(fs::exists(path(door.first))) << door.first;
    } else {
      EXPECT_EQ(said.code, 0) << door.first << ": " << said.err;
      EXPECT_TRUE(fs::exists(path(door.first))) << door.first;
      fs::remove_all(path(door.output));
    }
  }
  EXPECT_TRUE(unfinished().empty());
}

/// Nothing has been seen yet in the first.
TEST_F(Exports, AFrameMayBeEmpty) {
  clip::Clip clip = bake::testing::sample_clip(kFrames);
  clip.layers = {clip.layers[1]};
  std::vector<motion::Motion::Pose> poses = clip.layers[0].motion.poses();
  poses[0].health = motion::Health::kLost;
  clip.layers[0].motion = motion::Motion::rigid(poses);
  write(clip);
  expect_all_written("empty");
}

TEST_F(Exports, HoldNothingOfALayerWhereItIsAway) {
  clip::Clip clip = bake::testing::sample_clip(kFrames);
  for (clip::Layer& layer : clip.layers) layer.presence = motion::Presence::away_during({{0, 1}, {2, 3}});
  write(clip);
  expect_all_written("away");
  const std::string into = path("").string();
  const auto convert = [&](const std::string& output) {
    const Said said = run_kinora(folder_, {"convert", into + "clip.mkv", into + output, "-O", "triangles=2000"});
    EXPECT_EQ(said.code, 0) << said.err;
    EXPECT_EQ(said.err.find("shown all the same"), std::string::npos) << said.err;
  };
  convert("clip.ply");
  convert("clip.obj");
  convert("clip.usda");
  convert("clip.glb");
  for (const char* number : {"1", "3"}) {
    EXPECT_NE(contents_of(path(std::string("clip_000") + number + ".ply")).find("element vertex 0\n"),
              std::string::npos);
    EXPECT_EQ(contents_of(path(std::string("clip_000") + number + ".obj")).find("\nv "), std::string::npos);
  }
  EXPECT_EQ(contents_of(path("clip_0002.ply")).find("element vertex 0\n"), std::string::npos);
  EXPECT_NE(contents_of(path("clip_0002.obj")).find("\nv "), std::string::npos);
  const std::string usd = contents_of(path("clip.usda"));
  const std::string glb = contents_of(path("clip.glb"));
  for (const clip::Layer& layer : clip.layers) {
    const std::size_t mesh = usd.find("def Mesh \"" + layer.name);
    EXPECT_NE(usd.substr(mesh, usd.find("def Material", mesh) - mesh).find("visibility.timeSamples"),
              std::string::npos);
    EXPECT_NE(glb.find("\"" + layer.name + " shown\""), std::string::npos) << layer.name;
  }
}

TEST_F(Exports, HoldNothingOfNodesBeforeTheyAreBorn) {
  clip::Clip clip = bake::testing::sample_clip(kFrames);
  clip.layers = {clip.layers[2]};
  std::vector<std::uint32_t> births;
  for (const Eigen::Vector3d& node : clip.layers[0].motion.graph()->nodes()) births.push_back(node.x() > -0.31 ? 2 : 0);
  clip.layers[0].births = motion::NodeBirths(std::move(births));
  write(clip);
  expect_all_written("late");
  const auto vertices = [&](const char* number) {
    const std::string ply = contents_of(path(std::string("late4/clip_000") + number + ".ply"));
    return std::stoi(ply.substr(ply.find("element vertex ") + 15));
  };
  EXPECT_LT(vertices("1"), 0.8 * vertices("3"));
  EXPECT_EQ(vertices("1"), vertices("2"));
  const std::string name = clip.layers[0].name + " from frame 2";
  EXPECT_NE(contents_of(path("late1/clip.glb")).find(name + " shown"), std::string::npos);
  EXPECT_NE(contents_of(path("late3/clip.usda")).find("visibility.timeSamples"), std::string::npos);
}

TEST_F(Exports, NamesMayHaveSpacesQuotesAndLettersOfAllLanguages) {
  clip::Clip clip = bake::testing::sample_clip(kFrames);
  clip.layers[1].name = "Karton \"groß\"";
  clip.layers[2].name = "人 Åse";
  write(clip);
  expect_all_written("Ordner für 'Bilder' 日本 ");
}

TEST_F(Exports, PlacesThatCannotBeWrittenAreNamedAndNothingIsLeft) {
  folder_.write("file", "in the way");
  const auto before = names_in(folder_.path());
  for (const Door& door : kDoors) {
    for (const char* into : {"file/", "absent/deeper/"}) {
      if (door.words[0] == "render" && std::string(into) != "file/") continue; // makes its folders
      expect_error(run(door, into), 5, into + door.output.substr(0, door.output.find('.')));
    }
  }
  auto after = names_in(folder_.path());
  std::erase(after, "stdout.txt");
  EXPECT_EQ(after, before);
}

/// Cameras that look away, and so empty pictures in every format of pictures.
TEST_F(Exports, PicturesMayShowNothing) {
  folder_.write("away.json", R"({"w": 64, "h": 48, "fl_x": 52, "frames": [
    {"file_path": "000000", "frame": 0, "transform_matrix": [[1,0,0,0],[0,1,0,50],[0,0,1,0],[0,0,0,1]]},
    {"file_path": "000001", "frame": 1, "transform_matrix": [[1,0,0,0],[0,1,0,50],[0,0,1,0],[0,0,0,1]]}]})");
  for (const Door& door : kDoors) {
    if (door.words[0] != "render") continue;
    const Said said = run(door, "", {"--cameras", path("away.json").string()});
    EXPECT_EQ(said.code, 0) << door.first << ": " << said.err;
    EXPECT_TRUE(fs::exists(path(door.first))) << door.first;
    fs::remove_all(path(door.output));
  }
  EXPECT_TRUE(unfinished().empty());
}

/// The largest file that a program may write stands for a disk that is full.
TEST_F(Exports, FullDisksAreToldOfAndNothingIsLeft) {
  for (const Door& door : kDoors) {
    std::vector<std::string> words = words_of(door, "");
    words.insert(words.begin(), {"-c", R"(trap "" XFSZ; ulimit -f 1; exec "$0" "$@")", KINORA_PROGRAM});
    const Said said = Running(folder_.path(), words, {}, "/bin/bash").finish();
    expect_error(said, 5, "cannot be written");
    EXPECT_FALSE(fs::exists(path(door.first))) << door.first;
    fs::remove_all(path("pictures"));
  }
  EXPECT_TRUE(unfinished().empty());
}

TEST_F(Exports, OptionsThatDoNotExistAreToldWithTheNearest) {
  const std::pair<std::string, std::string> slips[] = {
      {"clip.glb", "triangels"}, {"clip.usda", "textur"}, {"clip.ply", "contents"}, {"clip.obj", "unit"},
      {"clip.vdb", "voxels"},    {"film.mp4", "fsp"},     {"views.exr", "veiws"},   {"still.png", "layuot"}};
  for (const auto& [output, slip] : slips) {
    const bool pictures = output == "film.mp4" || output == "views.exr" || output == "still.png";
    const std::string command = pictures ? "render" : "convert";
    const Said said =
        run_kinora(folder_, {command, path("clip.mkv").string(), path(output).string(), "-O", slip + "=1"});
    expect_error(said, 2,
                 "no option \"" + slip + "\"; the nearest is " +
                     std::map<std::string, std::string>{{"triangels", "triangles"},
                                                        {"textur", "texture"},
                                                        {"contents", "content"},
                                                        {"unit", "units"},
                                                        {"voxels", "voxel"},
                                                        {"fsp", "fps"},
                                                        {"veiws", "views"},
                                                        {"layuot", "layout"}}[slip]);
    EXPECT_FALSE(fs::exists(path(output)));
  }
  const Said said = run_kinora(folder_, {"render", path("clip.mkv").string(), path("set").string(), "-O",
                                         "format=data-set", "-O", "layout=file"});
  expect_error(said, 2, "data-set has no options");
  EXPECT_FALSE(fs::exists(path("set")));
}

TEST_F(Exports, InterruptionLeavesWholeFilesOrNone) {
  write(bake::testing::sample_clip(60));
  for (const Door& door : kDoors) {
    folder_.write("precious", "mine");
    Running running(folder_.path(), words_of(door, ""));
    ASSERT_TRUE(running.wait_for(door.stage)) << door.first;
    running.interrupt();
    expect_error(running.finish(), 130, "interrupted");
    EXPECT_TRUE(unfinished().empty()) << door.first;
    fs::remove_all(path(door.output));
    fs::remove(path(door.first));
  }
}

/// All that is tested here holds for a new format too.
TEST_F(Exports, HaveADoorForEachFormat) {
  std::set<std::string> doors;
  for (const Door& door : kDoors) doors.insert(door.format);
  EXPECT_EQ(doors, export_formats(folder_));
}

TEST_F(Exports, SequencesGoOnWhereTheyWereInterrupted) {
  for (const Door& door : kDoors) {
    if (door.first.find("_0001") == std::string::npos) continue;
    ASSERT_EQ(run(door, "").code, 0);
    const std::string second = std::string(door.first).replace(door.first.find("_0001"), 5, "_0002");
    const std::string expected = contents_of(path(second));
    fs::remove(path(second));
    folder_.write(door.first, "kept");
    const Said said = run(door, "", {"--resume"});
    EXPECT_EQ(said.code, 0) << said.err;
    EXPECT_EQ(contents_of(path(door.first)), "kept");
    EXPECT_EQ(contents_of(path(second)), expected) << second;
  }
  expect_error(run(kDoors[0], "", {"--resume"}), 2, "--resume");
}

TEST_F(Exports, FoldersOfPicturesGoOnToo) {
  for (const Door& door : kDoors) {
    const bool film = door.output.ends_with(".mp4") || door.output.ends_with(".webm"); // Render.AFilmGoesOn… is of them
    if (door.words[0] != "render" || film) continue;
    if (door.output != "pictures") {
      expect_error(run(door, "", {"--resume"}), 2, "--resume");
      EXPECT_FALSE(fs::exists(path(door.first))) << door.first;
      continue;
    }
    const bool passes_beside = door.format == "png";
    const std::vector<std::string> passes{"--passes", passes_beside ? "rgb,depth" : "rgb,deep"};
    const std::string end = passes_beside ? ".png" : ".exr";
    const std::string pass = (passes_beside ? ".depth" : ".deep") + end;
    const auto resumed = [&] { return run(door, "", {passes[0], passes[1], "--resume"}); };
    ASSERT_EQ(resumed().code, 0) << "nothing is there yet";
    const std::string second = contents_of(path("pictures/000001" + end));
    const std::string third = contents_of(path("pictures/000002" + pass));
    for (const std::string& name : {"000000" + end, "000001" + pass, "000002" + end})
      folder_.write("pictures/" + name, "kept");
    fs::remove(path("pictures/000001" + end));
    fs::remove(path("pictures/000002" + pass));
    const Said said = resumed();
    EXPECT_EQ(said.code, 0) << said.err;
    EXPECT_EQ(contents_of(path("pictures/000000" + end)), "kept");
    EXPECT_EQ(contents_of(path("pictures/000001" + end)), second);
    EXPECT_EQ(contents_of(path("pictures/000002" + pass)), third);
    EXPECT_NE(contents_of(path("pictures/000001" + pass)), "kept") << "a picture is made with all its passes";
    EXPECT_EQ(resumed().code, 0) << "all are there";
    fs::remove_all(path("pictures"));
  }
  EXPECT_TRUE(unfinished().empty());
}

} // namespace
} // namespace kinora::test
