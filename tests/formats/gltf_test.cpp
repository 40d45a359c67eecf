// GLB files, read back by hand and judged by the Khronos validator where it is installed.
#include <gtest/gtest.h>

#include <cstdlib>
#include <map>
#include <set>

#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/image_codec.h"
#include "formats/sample_capture.h"
#include "host/mesh_writer.h"
#include "host/plugin_table.h"
#include "interop/gltf_validator.h"

namespace kinora::formats {
namespace {

using namespace kinora::test;
using Json = nlohmann::json;

SE3 pose_at(const Eigen::Vector3d& translation, double turn) {
  SE3 pose = SE3::Identity();
  pose.translation() = translation;
  pose.linear() = Eigen::AngleAxisd(turn, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  return pose;
}

/// A tetrahedron, 1 m on its edges, at (0, 0, 2).
host::Mesh tetrahedron(const std::string& name) {
  host::Mesh mesh;
  mesh.name = name;
  mesh.positions = {{0, 0, 2}, {1, 0, 2}, {0, 1, 2}, {0, 0, 3}};
  for (const auto& p : mesh.positions) {
    mesh.normals.push_back((p - Eigen::Vector3f(0.25F, 0.25F, 2.25F)).normalized());
    mesh.colors.push_back({255, 128, static_cast<std::uint8_t>(80 * p.x())});
  }
  mesh.faces = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return mesh;
}

host::Mesh carried(const std::string& name) {
  host::Mesh mesh = tetrahedron(name);
  mesh.skin.inverse_bind = {pose_at({0, 0, -2}, 0)};
  return mesh;
}

host::Mesh skinned(const std::string& name) {
  host::Mesh mesh = tetrahedron(name);
  for (int j = 0; j < 3; ++j) mesh.skin.inverse_bind.push_back(pose_at({-0.5 * j, 0, -2}, 0));
  mesh.skin.joints = {{0, 0, 0, 0}, {1, 0, 0, 0}, {2, 1, 0, 0}, {0, 1, 2, 0}};
  mesh.skin.weights = {{1, 0, 0, 0}, {1, 0, 0, 0}, {0.75F, 0.25F, 0, 0}, {1.0F / 3, 1.0F / 3, 1.0F / 3, 0}};
  return mesh;
}

struct Glb {
  Json json;
  std::string binary;

  /// The floats or other numbers of an accessor.
  template <class Value> std::vector<Value> values(int accessor, std::size_t components) const {
    const Json& a = json["accessors"][static_cast<std::size_t>(accessor)];
    const Json& view = json["bufferViews"][a["bufferView"].get<std::size_t>()];
    std::vector<Value> out(a["count"].get<std::size_t>() * components);
    EXPECT_EQ(view["byteLength"].get<std::size_t>(), out.size() * sizeof(Value));
    std::memcpy(out.data(), binary.data() + view["byteOffset"].get<std::size_t>(), out.size() * sizeof(Value));
    return out;
  }
  const Json& node(const std::string& name) const {
    for (const Json& n : json["nodes"])
      if (n["name"] == name) return n;
    throw std::runtime_error("no node " + name);
  }
};

std::uint32_t number_at(const std::string& bytes, std::size_t offset) {
  std::uint32_t number = 0;
  std::memcpy(&number, bytes.data() + offset, sizeof number);
  return number;
}

Glb read_glb(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(file)), {});
  EXPECT_EQ(bytes.substr(0, 4), "glTF");
  EXPECT_EQ(number_at(bytes, 4), 2U);
  EXPECT_EQ(number_at(bytes, 8), bytes.size());
  const std::size_t json_bytes = number_at(bytes, 12);
  EXPECT_EQ(bytes.substr(16, 4), "JSON");
  EXPECT_EQ(json_bytes % 4, 0U);
  const std::size_t binary = 20 + json_bytes;
  EXPECT_EQ(number_at(bytes, binary) + binary + 8, bytes.size());
  return {Json::parse(bytes.substr(20, json_bytes)), bytes.substr(binary + 8)};
}

class GlbWriterTest : public testing::Test {
protected:
  fs::path path(const std::string& name = "scene.glb") const { return folder_.path() / name; }
  host::MeshWriter open(const std::string& name = "scene.glb", const host::Options& options = {}) {
    return {table_.find("glb"), path(name), options};
  }

  /// Still, carried and skinned, over three frames.
  fs::path write_scene(const std::string& name = "scene.glb", const host::Options& options = {{"quantize", "false"}}) {
    host::MeshWriter writer = open(name, options);
    writer.add(tetrahedron("background"));
    writer.add(carried("object"));
    writer.add(skinned("person"));
    for (int i = 0; i < 3; ++i) {
      const std::vector<SE3> one = {pose_at({0.1 * i, 0, 2}, 2.5 * i)};
      const std::vector<SE3> three = {pose_at({0, 0, 2}, 0), pose_at({0.5, 0.1 * i, 2}, 0),
                                      pose_at({1, 0, 2}, 0.3 * i)};
      writer.pose(1, i / 30.0, one);
      writer.pose(2, i / 30.0, three);
    }
    writer.finish();
    return path(name);
  }

  TemporaryFolder folder_;
  host::PluginTable table_ = host::PluginTable::builtin();
};

template <class Call> void expect_refusal(ErrorCode code, const std::string& word, const Call& call) {
  try {
    call();
    ADD_FAILURE() << "nothing was thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
  }
}

TEST_F(GlbWriterTest, LayersAreNodesByNameWithAnUnlitMaterial) {
  const Glb glb = read_glb(write_scene());
  for (const char* name : {"background", "object", "person"}) EXPECT_TRUE(glb.node(name).contains("mesh"));
  EXPECT_EQ(glb.json["extensionsUsed"], Json({"KHR_materials_unlit"}));
  EXPECT_TRUE(glb.json["materials"][0]["extensions"].contains("KHR_materials_unlit"));
  EXPECT_EQ(glb.json["asset"]["version"], "2.0");
}

TEST_F(GlbWriterTest, TheRootTurnsYUp) {
  const Glb glb = read_glb(write_scene());
  const Json& root = glb.json["nodes"][0];
  const auto q = root["rotation"].get<std::vector<double>>();
  const Eigen::Quaterniond turn(q[3], q[0], q[1], q[2]);
  EXPECT_LT((turn * Eigen::Vector3d(1, 2, 3) - Eigen::Vector3d(1, -2, -3)).norm(), 1e-12);
  EXPECT_EQ(glb.json["scenes"][0]["nodes"][0], 0);
}

TEST_F(GlbWriterTest, ColorsAreLinearLight) {
  const Glb glb = read_glb(write_scene());
  const auto colors =
      glb.values<std::uint16_t>(glb.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"].get<int>(), 4);
  EXPECT_EQ(colors[0], 65535);
  EXPECT_NEAR(colors[1], 0.2158605 * 65535, 1); // IEC 61966-2-1 of 128
  EXPECT_EQ(colors[2], 0);
  EXPECT_EQ(colors[3], 65535);
}

TEST_F(GlbWriterTest, CarriedMeshesLieInTheSpaceOfTheirNode) {
  const Glb glb = read_glb(write_scene());
  const auto positions =
      glb.values<float>(glb.json["meshes"][1]["primitives"][0]["attributes"]["POSITION"].get<int>(), 3);
  EXPECT_EQ(positions, (std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}));
  EXPECT_EQ(glb.node("object")["translation"], Json({0.0, 0.0, 2.0}));
}

TEST_F(GlbWriterTest, AnimationHoldsWhatMovesAndTurnsTheShortWay) {
  const Glb glb = read_glb(write_scene());
  const Json& animation = glb.json["animations"][0];
  ASSERT_EQ(animation["channels"].size(), 4U); // object turns and moves; joint 1 moves, joint 2 turns
  std::set<int> inputs;
  for (const Json& sampler : animation["samplers"]) {
    inputs.insert(sampler["input"].get<int>());
    EXPECT_EQ(sampler["interpolation"], "LINEAR");
  }
  ASSERT_EQ(inputs.size(), 1U);
  const auto times = glb.values<float>(*inputs.begin(), 1);
  EXPECT_FLOAT_EQ(times[2], 2 / 30.0F);
  EXPECT_EQ(animation["channels"][0]["target"]["path"], "rotation");
  const auto q = glb.values<float>(animation["samplers"][0]["output"].get<int>(), 4);
  ASSERT_EQ(q.size(), 12U);
  for (std::size_t i = 4; i < 12; i += 4) {
    float agreement = 0;
    for (std::size_t c = 0; c < 4; ++c) agreement += q[i + c] * q[i - 4 + c];
    EXPECT_GT(agreement, 0);
  }
}

TEST_F(GlbWriterTest, WeightsAddUpExactlyAndBindMatricesAreColumns) {
  const Glb glb = read_glb(write_scene());
  const Json& attributes = glb.json["meshes"][2]["primitives"][0]["attributes"];
  const auto weights = glb.values<std::uint16_t>(attributes["WEIGHTS_0"].get<int>(), 4);
  for (std::size_t v = 0; v < weights.size(); v += 4)
    EXPECT_EQ(weights[v] + weights[v + 1] + weights[v + 2] + weights[v + 3], 65535);
  const Json& skin = glb.json["skins"][0];
  EXPECT_EQ(skin["joints"].size(), 3U);
  const auto bind = glb.values<float>(skin["inverseBindMatrices"].get<int>(), 16);
  EXPECT_FLOAT_EQ(bind[16 + 12], -0.5F);
  EXPECT_FLOAT_EQ(bind[14], -2);
  EXPECT_FLOAT_EQ(bind[15], 1);
}

TEST_F(GlbWriterTest, TheAssetSaysHowItWasMade) {
  host::MeshWriter writer(table_.find("glb"), path(), {}, {{"source", "clip.mkv"}, {"lost", "the skeleton"}});
  writer.add(tetrahedron("background"));
  writer.finish();
  EXPECT_EQ(read_glb(path()).json["asset"]["extras"], Json({{"source", "clip.mkv"}, {"lost", "the skeleton"}}));
}

TEST_F(GlbWriterTest, StepsHoldAPose) {
  const Glb glb = read_glb(write_scene("steps.glb", {{"interpolation", "step"}, {"quantize", "false"}}));
  EXPECT_EQ(glb.json["animations"][0]["samplers"][0]["interpolation"], "STEP");
}

TEST_F(GlbWriterTest, SingleFramesAreNotAnimated) {
  host::MeshWriter writer = open();
  writer.add(carried("object"));
  writer.pose(0, 0, std::vector<SE3>{pose_at({1, 2, 3}, 0.5)});
  writer.finish();
  const Glb glb = read_glb(path());
  EXPECT_FALSE(glb.json.contains("animations"));
  EXPECT_EQ(glb.node("object")["translation"], Json({1.0, 2.0, 3.0}));
}

host::Mesh textured(const std::string& name) {
  host::Mesh mesh = tetrahedron(name);
  mesh.colors.clear();
  mesh.texture = ColorImage(8, 4, 3, 200);
  mesh.texture_coordinates = {{0, 0}, {1, 0}, {0, 1}, {0.5F, 0.5F}};
  return mesh;
}

/// The positions of a mesh of 4 vertices as its node brings them back, in any order.
std::set<std::array<int, 3>> places_of(const Json& node, const std::vector<std::uint16_t>& stored) {
  const auto scale = node.value("scale", std::vector<double>{1, 1, 1});
  const auto offset = node.value("translation", std::vector<double>(3));
  std::set<std::array<int, 3>> places;
  for (std::size_t v = 0; v < stored.size(); v += 4) {
    std::array<int, 3> place{};
    for (std::size_t c = 0; c < 3; ++c)
      place[c] = static_cast<int>(std::lround(1000 * (offset[c] + scale[c] * stored[v + c] / 65535)));
    places.insert(place);
  }
  return places;
}

TEST_F(GlbWriterTest, QuantizedPositionsAreBroughtBackByTheNodeThatHasThem) {
  const Glb glb = read_glb(write_scene("small.glb", {}));
  const Json& node = glb.node("background");
  const Json& attributes = glb.json["meshes"][0]["primitives"][0]["attributes"];
  const auto stored = glb.values<std::uint16_t>(attributes["POSITION"].get<int>(), 4); // with two bytes of padding
  const std::set<std::array<int, 3>> expected{{0, 0, 2000}, {1000, 0, 2000}, {0, 1000, 2000}, {0, 0, 3000}};
  EXPECT_EQ(places_of(node, stored), expected);
  EXPECT_EQ(glb.json["extensionsRequired"], Json({"KHR_mesh_quantization"}));
}

TEST_F(GlbWriterTest, TexturesAreJpegOrPngInsideTheFile) {
  for (const auto& [quality, type] : {std::pair("88", "image/jpeg"), std::pair("0", "image/png")}) {
    host::MeshWriter writer = open("textured.glb", {{"jpeg", quality}});
    writer.add(textured("background"));
    writer.finish();
    const Glb glb = read_glb(path("textured.glb"));
    EXPECT_EQ(glb.json["images"][0]["mimeType"], type);
    const Json& view = glb.json["bufferViews"][glb.json["images"][0]["bufferView"].get<std::size_t>()];
    const std::string bytes =
        glb.binary.substr(view["byteOffset"].get<std::size_t>(), view["byteLength"].get<std::size_t>());
    const ColorImage picture = decode_color(std::as_bytes(std::span(bytes)), "texture");
    EXPECT_EQ(picture.width(), 8);
    EXPECT_NEAR(picture.at(3, 2, 1), 200, 2);
    EXPECT_EQ(glb.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"], 0);
  }
  expect_refusal(ErrorCode::kUsage, "1 to 100", [&] { open("textured.glb", {{"jpeg", "101"}}); });
}

TEST_F(GlbWriterTest, CompressedFilesSayWhatTheyNeedAndKeepTheirCounts) {
  for (const auto& [compression, extension] :
       {std::pair("meshopt", "EXT_meshopt_compression"), std::pair("draco", "KHR_draco_mesh_compression")}) {
    const Glb glb = read_glb(write_scene("packed.glb", {{"compression", compression}}));
    const auto required = glb.json["extensionsRequired"].get<std::set<std::string>>();
    EXPECT_TRUE(required.contains(extension)) << compression;
    const Json& primitive = glb.json["meshes"][2]["primitives"][0];
    EXPECT_EQ(glb.json["accessors"][primitive["indices"].get<std::size_t>()]["count"], 12);
    EXPECT_EQ(glb.json["accessors"][primitive["attributes"]["JOINTS_0"].get<std::size_t>()]["count"], 4);
  }
}

TEST_F(GlbWriterTest, SequencesShowOneMeshAtAnyTime) {
  const Glb glb = read_glb(write_scene("sequence.glb", {{"animation", "sequence"}}));
  EXPECT_FALSE(glb.json.contains("skins"));
  const Json& above = glb.node("person");
  ASSERT_EQ(above["children"].size(), 3U);
  std::array<std::array<float, 3>, 3> sizes{}; // of each node at each time
  std::size_t sequences = 0;
  for (const Json& channel : glb.json["animations"][0]["channels"]) {
    if (channel["target"]["path"] != "scale") continue;
    ++sequences;
    const Json& sampler = glb.json["animations"][0]["samplers"][channel["sampler"].get<std::size_t>()];
    EXPECT_EQ(sampler["interpolation"], "STEP");
    const auto times = glb.values<float>(sampler["input"].get<int>(), 1);
    const auto scales = glb.values<float>(sampler["output"].get<int>(), 3);
    const int node = channel["target"]["node"].get<int>() - above["children"][0].get<int>();
    for (std::size_t frame = 0; frame < 3; ++frame) {
      for (std::size_t k = 0; k < times.size(); ++k) {
        if (k == 0 || times[k] <= static_cast<float>(frame) / 30 + 1e-6F)
          sizes[static_cast<std::size_t>(node)][frame] = scales[3 * k];
      }
    }
  }
  EXPECT_EQ(sequences, 3U);
  for (std::size_t node = 0; node < 3; ++node)
    for (std::size_t frame = 0; frame < 3; ++frame) EXPECT_EQ(sizes[node][frame], node == frame ? 1 : 0);
  // Joint 1 has risen by 0.2 m in the last frame; vertex 1 hangs on it alone.
  const Json& last = glb.json["nodes"][above["children"][2].get<std::size_t>()];
  const Json& primitive = glb.json["meshes"][last["mesh"].get<std::size_t>()]["primitives"][0];
  const auto stored = glb.values<std::uint16_t>(primitive["attributes"]["POSITION"].get<int>(), 4);
  EXPECT_TRUE(places_of(above, stored).contains({1000, 200, 2000}));
  EXPECT_EQ(primitive["indices"], glb.json["meshes"][last["mesh"].get<std::size_t>() - 1]["primitives"][0]["indices"]);
}

TEST_F(GlbWriterTest, MorphTargetsMixToTheShapeOfEachFrame) {
  const Glb glb = read_glb(write_scene("morph.glb", {{"animation", "morph"}, {"quantize", "false"}}));
  const Json& node = glb.node("person");
  const Json& mesh = glb.json["meshes"][node["mesh"].get<std::size_t>()];
  const Json& primitive = mesh["primitives"][0];
  const std::size_t count = primitive["targets"].size();
  ASSERT_EQ(count, 2U); // three frames differ from their mean in two ways
  EXPECT_EQ(mesh["extras"]["targetNames"].size(), count);
  EXPECT_LT(mesh["extras"]["error"], 1e-4);
  auto points = glb.values<float>(primitive["attributes"]["POSITION"].get<int>(), 3);
  std::vector<float> weights;
  for (const Json& channel : glb.json["animations"][0]["channels"]) {
    if (channel["target"]["path"] != "weights") continue;
    weights = glb.values<float>(
        glb.json["animations"][0]["samplers"][channel["sampler"].get<std::size_t>()]["output"].get<int>(), 1);
  }
  ASSERT_EQ(weights.size(), 3 * count);
  EXPECT_EQ(*std::min_element(weights.begin(), weights.end()), 0);
  EXPECT_EQ(*std::max_element(weights.begin(), weights.end()), 1);
  for (std::size_t k = 0; k < count; ++k) {
    const auto shape = glb.values<float>(primitive["targets"][k]["POSITION"].get<int>(), 3);
    for (std::size_t i = 0; i < points.size(); ++i) points[i] += weights[2 * count + k] * shape[i];
  }
  EXPECT_NEAR(points[3], 1, 1e-4);
  EXPECT_NEAR(points[4], 0.2, 1e-4);
  EXPECT_NEAR(points[5], 2, 1e-4);
}

TEST_F(GlbWriterTest, FewShapesAreNoMoreThanAskedForAndSayHowFarOffTheyAre) {
  const Glb glb = read_glb(write_scene("morph.glb", {{"animation", "morph"}, {"shapes", "1"}}));
  const Json& mesh = glb.json["meshes"][glb.node("person")["mesh"].get<std::size_t>()];
  EXPECT_EQ(mesh["primitives"][0]["targets"].size(), 1U);
  EXPECT_GT(mesh["extras"]["error"], 1e-4);
  expect_refusal(ErrorCode::kUsage, "1 to 64", [&] { open("morph.glb", {{"shapes", "65"}}); });
  expect_refusal(ErrorCode::kUsage, "no morph targets", [&] {
    open("morph.glb", {{"animation", "morph"}, {"compression", "draco"}});
  });
}

TEST_F(GlbWriterTest, DracosOwnDecoderUnpacksTheMeshes) {
  if (std::system("draco_decoder -h > /dev/null 2>&1") != 0) GTEST_SKIP() << "draco_decoder is not installed";
  const Glb glb = read_glb(write_scene("packed.glb", {{"compression", "draco"}, {"animation", "sequence"}}));
  ASSERT_EQ(glb.json["meshes"].size(), 5U); // still, carried, and one for each of three frames
  for (const Json& mesh : glb.json["meshes"]) {
    const Json& extension = mesh["primitives"][0]["extensions"]["KHR_draco_mesh_compression"];
    const Json& view = glb.json["bufferViews"][extension["bufferView"].get<std::size_t>()];
    folder_.write("mesh.drc",
                  glb.binary.substr(view["byteOffset"].get<std::size_t>(), view["byteLength"].get<std::size_t>()));
    const std::string command =
        "draco_decoder -i '" + path("mesh.drc").string() + "' -o '" + path("mesh.obj").string() + "' > /dev/null";
    ASSERT_EQ(std::system(command.c_str()), 0);
    std::map<std::string, int> lines; // by their first word
    std::ifstream file(path("mesh.obj"));
    for (std::string line; std::getline(file, line);) ++lines[line.substr(0, line.find(' '))];
    EXPECT_EQ(lines["v"], 4);
    EXPECT_EQ(lines["f"], 4);
  }
}

TEST_F(GlbWriterTest, SameMeshesGiveTheSameBytes) {
  const auto bytes = [](const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return std::string((std::istreambuf_iterator<char>(stream)), {});
  };
  EXPECT_EQ(bytes(write_scene("a.glb")), bytes(write_scene("b.glb")));
}

TEST_F(GlbWriterTest, MeshesThatContradictThemselvesAreRefused) {
  const auto refused = [&](const std::string& word, const auto& damage) {
    host::Mesh mesh = skinned("person");
    damage(mesh);
    host::MeshWriter writer = open("bad.glb");
    expect_refusal(ErrorCode::kUsage, word, [&] { writer.add(mesh); });
  };
  refused("vertex that is not there", [](host::Mesh& m) { m.faces[1][2] = 4; });
  refused("joint that is not there", [](host::Mesh& m) { m.skin.joints[2][1] = 3; });
  refused("add up", [](host::Mesh& m) { m.skin.weights[2][1] = 0.5F; });
  refused("finite", [](host::Mesh& m) { m.positions[0].x() = std::numeric_limits<float>::infinity(); });
  refused("no faces", [](host::Mesh& m) { m.faces.clear(); });
}

TEST_F(GlbWriterTest, PosesThatContradictTheMeshAreRefused) {
  host::MeshWriter writer = open();
  writer.add(carried("object"));
  const std::vector<SE3> one = {SE3::Identity()};
  const std::vector<SE3> two(2, SE3::Identity());
  expect_refusal(ErrorCode::kUsage, "not there", [&] { writer.pose(1, 0, one); });
  expect_refusal(ErrorCode::kUsage, "as many joints", [&] { writer.pose(0, 0, two); });
  writer.pose(0, 1, one);
  expect_refusal(ErrorCode::kUsage, "increase", [&] { writer.pose(0, 1, one); });
  expect_refusal(ErrorCode::kUsage, "before the first pose", [&] { writer.add(carried("late")); });
}

/// A mesh over four frames, hidden in the first and the last one.
fs::path write_hidden(host::MeshWriter writer, const host::Mesh& mesh, const fs::path& path) {
  writer.add(mesh);
  const std::vector<SE3> joints(mesh.skin.inverse_bind.size(), SE3::Identity());
  for (int i = 0; i < 4; ++i) writer.pose(0, i, joints, i == 0 || i == 3);
  writer.finish();
  return path;
}

TEST_F(GlbWriterTest, AHiddenMeshHasNoSize) {
  for (const auto& [animation, mesh] : std::vector<std::pair<std::string, host::Mesh>>{{"skin", carried("box")},
                                                                                       {"skin", skinned("box")},
                                                                                       {"morph", skinned("box")},
                                                                                       {"sequence", skinned("box")}}) {
    const fs::path file =
        write_hidden(open("hidden.glb", {{"animation", animation}, {"quantize", "false"}}), mesh, path("hidden.glb"));
    const Glb glb = read_glb(file);
    const Json& shown = glb.node("box shown");
    EXPECT_EQ(shown["scale"], Json({0, 0, 0}));
    EXPECT_FALSE(shown["children"].empty());
    bool found = false;
    for (const Json& channel : glb.json["animations"][0]["channels"]) {
      if (glb.json["nodes"][channel["target"]["node"].get<std::size_t>()]["name"] != "box shown") continue;
      const Json& sampler = glb.json["animations"][0]["samplers"][channel["sampler"].get<std::size_t>()];
      EXPECT_EQ(channel["target"]["path"], "scale");
      EXPECT_EQ(sampler["interpolation"], "STEP");
      EXPECT_EQ(glb.values<float>(sampler["input"], 1), (std::vector<float>{0, 1, 3}));
      EXPECT_EQ(glb.values<float>(sampler["output"], 3), (std::vector<float>{0, 0, 0, 1, 1, 1, 0, 0, 0}));
      found = true;
    }
    EXPECT_TRUE(found) << animation;
    if (test::has_gltf_validator()) {
      EXPECT_TRUE(test::is_valid_gltf({file})) << animation;
    }
  }
}

TEST_F(GlbWriterTest, UnwritablePlacesAndEmptyFilesAreErrors) {
  expect_refusal(ErrorCode::kUnwritableOutput, "absent", [&] { open("absent/a.glb"); });
  host::MeshWriter empty = open();
  expect_refusal(ErrorCode::kFailure, "no mesh", [&] { empty.finish(); });
  expect_refusal(ErrorCode::kUsage, "does not write meshes", [&] { host::MeshWriter(table_.find("png"), path(), {}); });
}

TEST_F(GlbWriterTest, KhronosValidatorFindsNothing) {
  if (!test::has_gltf_validator()) GTEST_SKIP() << "the glTF validator is not installed; run tests/interop/install";
  write_scene("linear.glb");
  write_scene("steps.glb", {{"interpolation", "step"}});
  host::MeshWriter still = open("still.glb");
  still.add(tetrahedron("Ärger \"quoted\""));
  still.finish();
  write_scene("small.glb", {});
  for (const char* animation : {"morph", "sequence"}) {
    for (const char* quantize : {"true", "false"})
      write_scene(std::string(animation) + quantize + ".glb", {{"animation", animation}, {"quantize", quantize}});
  }
  host::MeshWriter picture = open("picture.glb");
  picture.add(textured("background"));
  picture.finish();
  EXPECT_TRUE(test::is_valid_gltf({path("linear.glb"), path("steps.glb"), path("still.glb"), path("small.glb"),
                                   path("picture.glb"), path("morphtrue.glb"), path("morphfalse.glb"),
                                   path("sequencetrue.glb"), path("sequencefalse.glb")}));
  const std::pair<const char*, const char*> packed[] = {
      {"skin", "meshopt"}, {"skin", "draco"}, {"morph", "meshopt"}, {"sequence", "meshopt"}, {"sequence", "draco"}};
  for (const auto& [animation, compression] : packed) {
    const fs::path file = write_scene("packed.glb", {{"animation", animation}, {"compression", compression}});
    EXPECT_TRUE(test::is_valid_gltf({file})) << animation << ", " << compression;
  }
}

} // namespace
} // namespace kinora::formats
