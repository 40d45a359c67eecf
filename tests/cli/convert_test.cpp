// kinora convert and kinora track, as a user runs them, on a clip made here.
#include <cstdlib>
#include <cstring>
#include <map>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "bake/analytic_field.h"
#include "cli/run_kinora.h"
#include "clip/clip_io.h"
#include "interop/gltf_validator.h"

namespace kinora::test {
namespace {

using Json = nlohmann::json;

class ConvertTest : public testing::Test {
protected:
  ConvertTest() {
    clip::write_clip(bake::testing::sample_clip(kFrames), clip());
    folder_.write("points.csv", "id,x,y,z\nstill,0,0,0.05\nbox,0.3,0.1,0\nhand,-0.3,0.1,0\n");
  }

  fs::path path(const std::string& name) const { return folder_.path() / name; }
  std::string clip() const { return path("clip.mkv").string(); }
  Said convert(const std::string& output, std::vector<std::string> more = {}) {
    std::vector<std::string> words = {"convert", clip(), path(output).string(), "-O",
                                      path(output).extension() == ".vdb" ? "voxel=0.05" : "triangles=2000"};
    words.insert(words.end(), more.begin(), more.end());
    return run_kinora(folder_, words);
  }
  Said track(const std::string& points, const std::string& frame) {
    return run_kinora(folder_, {"track", clip(), "--points", path(points).string(), "--frame", frame, "--out",
                                path("tracks.csv").string()});
  }

  static constexpr int kFrames = 4;
  TemporaryFolder folder_;
};

using TrackTest = ConvertTest;

TEST_F(ConvertTest, ClipBecomesOneAnimatedFile) {
  const Said said = convert("out.glb", {"--json"});
  ASSERT_EQ(said.code, 0) << said.err;
  const Json told = Json::parse(said.out);
  EXPECT_EQ(told["schema"], "kinora.convert/1");
  EXPECT_EQ(told["frames"], kFrames);
  ASSERT_EQ(told["layers"].size(), 3U);
  EXPECT_EQ(told["layers"][1]["joints"], 1);
  EXPECT_GT(told["layers"][2]["joints"], 4);
  EXPECT_LT(told["layers"][2]["blending_difference"]["largest_m"], 0.01);
  EXPECT_EQ(told["bytes"], fs::file_size(path("out.glb")));
  EXPECT_EQ(contents_of(path("out.glb")).substr(0, 4), "glTF");
}

TEST_F(ConvertTest, KhronosValidatorFindsNothing) {
  if (!has_gltf_validator()) GTEST_SKIP() << "the glTF validator is not installed; run tests/interop/install";
  ASSERT_EQ(convert("out.glb").code, 0);
  EXPECT_TRUE(is_valid_gltf({path("out.glb")}));
}

TEST_F(ConvertTest, ClipBecomesNumberedVolumesInANewFolder) {
  const Said said = convert("volumes/clip.vdb", {"--frames", "1:4:2", "--json"});
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_EQ(Json::parse(said.out)["voxels"].size(), 2U);
  EXPECT_TRUE(fs::exists(path("volumes/clip_0001.vdb")));
  EXPECT_TRUE(fs::exists(path("volumes/clip_0002.vdb")));
  EXPECT_FALSE(fs::exists(path("volumes/clip_0003.vdb")));
  EXPECT_EQ(std::distance(fs::directory_iterator(path("volumes")), {}), 2);
}

TEST_F(ConvertTest, AnIndexShowsTheVolumesInTurn) {
  ASSERT_EQ(convert("volumes/clip.vdb", {"-O", "index=true", "-O", "fps=20", "--frames", "0:2"}).code, 0);
  const std::string usd = contents_of(path("volumes/clip.usda"));
  EXPECT_NE(usd.find("0: @@@./clip_0001.vdb@@@,"), std::string::npos) << usd;
  EXPECT_NE(usd.find("timeCodesPerSecond = 20\n"), std::string::npos) << usd;
  EXPECT_NE(usd.find("extent.timeSamples = {\n            0: [("), std::string::npos) << usd;
  fs::remove(path("volumes/clip_0001.vdb"));
  expect_error(convert("volumes/clip.vdb", {"-O", "index=true", "--frames", "0:1"}), 5, "clip.usda");
  EXPECT_FALSE(fs::exists(path("volumes/clip_0001.vdb"))) << "it is found out before the work";
  EXPECT_EQ(convert("volumes/clip.vdb", {"-O", "index=true", "--resume"}).code, 0);
  expect_error(convert("clip.vdb", {"-O", "index=maybe"}), 2, "true or false");
}

TEST_F(ConvertTest, ClipBecomesNumberedMeshesThatMove) {
  const Said said = convert("meshes/clip.ply", {"--frames", "1:4:2", "--json"});
  ASSERT_EQ(said.code, 0) << said.err;
  const Json told = Json::parse(said.out);
  EXPECT_EQ(told["files"], 2);
  ASSERT_EQ(told["layers"].size(), 3U);
  const std::string first = contents_of(path("meshes/clip_0001.ply"));
  const std::string second = contents_of(path("meshes/clip_0002.ply"));
  EXPECT_EQ(told["bytes"], first.size() + second.size());
  std::size_t vertices = 0;
  for (const Json& layer : told["layers"]) vertices += layer["vertices"].get<std::size_t>();
  EXPECT_NE(first.find("element vertex " + std::to_string(vertices) + "\n"), std::string::npos);
  ASSERT_EQ(first.size(), second.size());
  EXPECT_NE(first, second);
  std::size_t triangles = 0;
  for (const Json& layer : told["layers"]) triangles += layer["triangles"].get<std::size_t>();
  const std::size_t faces = 13 * triangles; // at the end: what a vertex is at one time, it is at all
  EXPECT_EQ(first.substr(first.size() - faces), second.substr(second.size() - faces));
  EXPECT_EQ(std::distance(fs::directory_iterator(path("meshes")), {}), 2);
}

TEST_F(ConvertTest, NumberedMeshesAreReplacedOnlyWhenAsked) {
  folder_.write("clip_0003.ply", "precious");
  expect_error(convert("clip.ply"), 5, "clip_0003.ply");
  EXPECT_FALSE(fs::exists(path("clip_0001.ply"))); // found out before the work
  EXPECT_EQ(convert("clip.ply", {"--overwrite"}).code, 0);
  EXPECT_EQ(contents_of(path("clip_0003.ply")).substr(0, 4), "ply\n");
}

TEST_F(ConvertTest, DryRunSaysWhatWouldBeWrittenAndWritesNothing) {
  const Said said = convert("volumes/clip.vdb", {"--dry-run", "--json"});
  ASSERT_EQ(said.code, 0) << said.err;
  const Json told = Json::parse(said.out);
  EXPECT_EQ(told["files"], kFrames);
  EXPECT_EQ(told["dry_run"], true);
  EXPECT_FALSE(fs::exists(path("volumes")));
}

TEST_F(ConvertTest, LayersMayBeChosenByName) {
  const Said said = convert("out.glb", {"-O", "layers=object,nobody", "--json"});
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_EQ(Json::parse(said.out)["layers"].size(), 1U);
  EXPECT_NE(said.err.find("nobody"), std::string::npos);
  expect_error(convert("other.glb", {"-O", "layers=nobody"}), 2, "background, object, person");
}

TEST_F(ConvertTest, FilesAreReplacedOnlyWhenAsked) {
  folder_.write("out.glb", "precious");
  expect_error(convert("out.glb"), 5, "--overwrite");
  EXPECT_EQ(contents_of(path("out.glb")), "precious");
  EXPECT_EQ(convert("out.glb", {"--overwrite"}).code, 0);
  EXPECT_NE(contents_of(path("out.glb")), "precious");
  folder_.write("clip_0003.vdb", "precious");
  expect_error(convert("clip.vdb"), 5, "clip_0003.vdb");
  EXPECT_FALSE(fs::exists(path("clip_0001.vdb"))); // found out before the work
}

/// x y z of the vertices of a PLY file.
std::vector<Eigen::Vector3f> vertices_of(const fs::path& file) {
  const std::string bytes = contents_of(file);
  const std::string key = "element vertex ";
  const auto count = static_cast<std::size_t>(std::stoul(bytes.substr(bytes.find(key) + key.size())));
  const std::size_t body = bytes.find("end_header\n") + 11;
  std::vector<Eigen::Vector3f> vertices(count);
  for (std::size_t v = 0; v < count; ++v) std::memcpy(vertices[v].data(), bytes.data() + body + 27 * v, 12);
  return vertices;
}

TEST_F(ConvertTest, TheOriginMayBeElsewhere) {
  ASSERT_EQ(convert("a.ply").code, 0);
  ASSERT_EQ(convert("b.ply", {"-O", "origin=1,2,-3"}).code, 0);
  const auto before = vertices_of(path("a_0002.ply"));
  const auto after = vertices_of(path("b_0002.ply"));
  ASSERT_EQ(before.size(), after.size());
  for (std::size_t v = 0; v < before.size(); v += 50)
    EXPECT_LT((before[v] - after[v] - Eigen::Vector3f(1, 2, -3)).norm(), 1e-5);
  EXPECT_NE(contents_of(path("b_0002.ply")).find("comment origin: 1, 2, -3\n"), std::string::npos);
  EXPECT_EQ(convert("a.glb", {"-O", "origin=1,2,-3"}).code, 0);
  EXPECT_EQ(convert("a.vdb", {"-O", "origin=1,2,-3"}).code, 0);
  expect_error(convert("c.ply", {"-O", "origin=1,2"}), 2, "three numbers");
}

TEST_F(ConvertTest, FramesMayComeAtAnotherRate) { // the clip has 10 per second
  EXPECT_EQ(Json::parse(convert("twice.ply", {"-O", "fps=20", "--json"}).out)["files"], 2 * kFrames - 1);
  EXPECT_NE(contents_of(path("twice_0003.ply")).find("comment frame: 1\n"), std::string::npos);
  const Json half = Json::parse(convert("half.ply", {"-O", "fps=5", "--json"}).out);
  EXPECT_EQ(half["files"], 2);
  EXPECT_NE(contents_of(path("half_0002.ply")).find("comment frame: 2\n"), std::string::npos);
  EXPECT_EQ(Json::parse(convert("twice.glb", {"-O", "fps=20", "--json"}).out)["frames"], kFrames);
  expect_error(convert("no.ply", {"-O", "fps=5000"}), 2, "at most 1000");
}

TEST_F(ConvertTest, FormatsListsWhatConvertTakes) {
  const Json told = Json::parse(run_kinora(folder_, {"formats", "--json"}).out);
  std::map<std::string, std::set<std::string>> names;
  for (const Json& format : told["formats"]) {
    for (const Json& option : format["options"]) {
      EXPECT_TRUE(names[format["name"]].insert(option["name"]).second)
          << option << " of " << format["name"] << ", twice";
      EXPECT_GT(option["help"].get<std::string>().size(), 10U) << option;
      EXPECT_NE(option["type"], "") << option;
    }
  }
  for (const char* name : {"layers", "fps", "origin", "triangles", "error", "up", "units"})
    EXPECT_TRUE(names["ply"].contains(name)) << name;
  EXPECT_TRUE(names["openvdb"].contains("voxel"));
  EXPECT_TRUE(names["glb"].contains("texture"));
  EXPECT_FALSE(names["ply"].contains("texture"));
  EXPECT_FALSE(names["png"].contains("layers"));
}

TEST_F(ConvertTest, WhatMakesNoSenseIsAUsageError) {
  expect_error(convert("out.xyz"), 2, ".glb");
  expect_error(convert("out.glb", {"--to", "png"}), 2, "kinora render");
  expect_error(convert("out.glb", {"--from", "tum-rgbd"}), 2, "kinora encode");
  expect_error(convert("out.glb", {"-O", "voxel=0.1"}), 2, "no option \"voxel\"");
  expect_error(convert("out.glb", {"-O", "triangles=-3"}), 2, "not negative");
  expect_error(convert("out.glb", {"--frames", "9:12"}), 2, "none of the 4 frames");
  EXPECT_FALSE(fs::exists(path("out.glb")));
  EXPECT_FALSE(fs::exists(path("out.glb.part")));
}

TEST_F(ConvertTest, StrictFailsWhereALayerHasNoSurface) {
  clip::Clip clip_with_nothing = bake::testing::sample_clip(1);
  clip_with_nothing.layers[0].field = fields::Field(bake::testing::unit_config());
  clip::write_clip(clip_with_nothing, clip());
  const Said lenient = convert("out.glb");
  EXPECT_EQ(lenient.code, 0) << lenient.err;
  EXPECT_NE(lenient.err.find("background: it has no surface"), std::string::npos);
  expect_error(convert("strict.glb", {"--strict"}), 1, "without --strict");
  EXPECT_FALSE(fs::exists(path("strict.glb")));
}

/// What moves in the file is labelled, as the layers are.
TEST_F(ConvertTest, AFileThatWasWrittenIsACaptureAgain) {
  ASSERT_EQ(convert("clip.glb").code, 0);
  const Said said = run_kinora(folder_, {"convert", path("clip.glb").string(), path("capture").string(), "-O", "fps=10",
                                         "-O", "width=160", "-O", "height=120"});
  if (said.code == 6) GTEST_SKIP() << "Kinora is built without tinygltf";
  ASSERT_EQ(said.code, 0) << said.err;
  std::ifstream labels(path("capture/labels.json"));
  const Json json = Json::parse(labels);
  ASSERT_EQ(json.size(), 2U) << json.dump();
  EXPECT_EQ(json["1"]["name"], "object mesh");
  EXPECT_EQ(json["1"]["kind"], "rigid");
  EXPECT_EQ(json["2"]["kind"], "deforming");
  EXPECT_EQ(names_in(path("capture/rgb")).size(), static_cast<std::size_t>(kFrames));
}

class TrackFrom : public TrackTest, public testing::WithParamInterface<int> {};

INSTANTIATE_TEST_SUITE_P(Track, TrackFrom, testing::Values(0, 2));

TEST_P(TrackFrom, EveryPointIsInEveryFrameAndFollowsItsLayer) {
  const clip::Clip truth = bake::testing::sample_clip(kFrames);
  const Eigen::Vector3d start[] = {{0, 0, 0.05}, {0.3, 0.1, 0}, {-0.3, 0.1, 0}}; // in canonical space
  const char* names[] = {"still", "box", "hand"};
  const int given = GetParam();
  std::string points = "id,x,y,z\n";
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Vector3d there = truth.layers[i].motion.warp(given).to_world(start[i]).value();
    points += fmt::format("{},{},{},{}\n", names[i], there.x(), there.y(), there.z());
  }
  folder_.write("given.csv", points);
  const Said said = track("given.csv", std::to_string(given));
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_NE(said.out.find("1 of background, 1 of object, 1 of person"), std::string::npos) << said.out;
  std::ifstream file(path("tracks.csv"));
  std::string line;
  std::getline(file, line);
  EXPECT_EQ(line, "frame,id,x,y,z");
  for (int frame = 0; frame < kFrames; ++frame) {
    for (std::size_t i = 0; i < 3; ++i) {
      ASSERT_TRUE(std::getline(file, line));
      std::replace(line.begin(), line.end(), ',', ' ');
      std::istringstream words(line);
      int number = -1;
      std::string id;
      Eigen::Vector3d position;
      words >> number >> id >> position.x() >> position.y() >> position.z();
      EXPECT_EQ(number, frame);
      EXPECT_EQ(id, names[i]);
      EXPECT_LT((position - truth.layers[i].motion.warp(frame).to_world(start[i]).value()).norm(), 0.002);
    }
  }
  EXPECT_FALSE(std::getline(file, line));
}

TEST_F(TrackTest, BadPointFilesNameTheLine) {
  const auto refused = [&](const std::string& text, const std::string& word) {
    folder_.write("bad.csv", text);
    const Said said = track("bad.csv", "0");
    expect_error(said, 4, "bad.csv, line " + word);
    EXPECT_FALSE(fs::exists(path("tracks.csv")));
  };
  refused("x,y,z,id\n", "1: the first line must be id,x,y,z");
  refused("id,x,y,z\na,1,2,3\nb,1,2\n", "3: 3 values");
  refused("id,x,y,z\na,1,2,three\n", "2: \"three\"");
  refused("id,x,y,z\na,1,2,nan\n", "2: \"nan\"");
  refused("id,x,y,z\na,1,2,3\n\nb,1,2,3\n", "3: 0 values");
  refused("id,x,y,z\na,1,2,3\na,1,2,4\n", "3: the id a came before");
  refused("id,x,y,z\n", "2: there is no point");
  refused("", "1:");
}

TEST_F(TrackTest, WindowsLineEndsAndByteOrderMarksAreFine) {
  folder_.write("windows.csv", "\xEF\xBB\xBFid,x,y,z\r\na,0,0,0.05\r\n");
  EXPECT_EQ(track("windows.csv", "3").code, 0);
}

TEST_F(TrackTest, FramesThatAreNotThereAreAUsageError) {
  expect_error(track("points.csv", "4"), 2, "frames 0 to 3");
  expect_error(track("absent.csv", "0"), 2, "absent.csv");
}

} // namespace
} // namespace kinora::test
