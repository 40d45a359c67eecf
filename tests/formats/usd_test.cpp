// USD text: what stands in it, by the letter. tests/interop has Blender open it.
#include <gtest/gtest.h>

#include "core/error.h"
#include "formats/sample_capture.h"
#include "formats/sample_triangle.h"

namespace kinora::formats {
namespace {

using namespace kinora::test;

class UsdTest : public testing::Test {
protected:
  fs::path path() const { return folder_.path() / "a clip.usda"; }
  std::string text() const {
    std::ifstream file(path());
    return {std::istreambuf_iterator<char>(file), {}};
  }
  host::MeshWriter open(const host::Options& options = {}) { return {table_.find("usd"), path(), options}; }

  static void expect_in(const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << part << "\nis not in\n" << text;
  }
  static std::string as_text(const Bytes& bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }
  static SE3 moved(double x) {
    SE3 pose = SE3::Identity();
    pose.translation().x() = x;
    return pose;
  }
  /// Joint 0 carries the first vertex, joint 1 the second, both the third.
  static host::Mesh skinned() {
    host::Mesh mesh = triangle("person", 0);
    mesh.skin.inverse_bind = {moved(0), moved(-1)};
    mesh.skin.joints = {{0, 1, 0, 0}, {0, 1, 0, 0}, {0, 1, 0, 0}};
    mesh.skin.weights = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0.5F, 0.5F, 0, 0}};
    return mesh;
  }

  TemporaryFolder folder_;
  host::PluginTable table_ = host::PluginTable::builtin();
};

TEST_F(UsdTest, AStillMeshHasNoTimeSamples) {
  write_meshes(table_.find("usd"), path(), {}, {triangle("a room", 1)});
  const std::string usd = text();
  EXPECT_TRUE(usd.starts_with("#usda 1.0\n"));
  expect_in(usd, "metersPerUnit = 1");
  expect_in(usd, "upAxis = \"Y\"");
  expect_in(usd, "double xformOp:rotateX = 180");
  expect_in(usd, "def Mesh \"a_room\"");
  expect_in(usd, "int[] faceVertexIndices = [0, 1, 2]");
  expect_in(usd, "point3f[] points = [(1, 0, 2), (1.1, 0, 2), (1, 0.5, 2)]");
  expect_in(usd, "float3[] extent = [(1, 0, 2), (1.1, 0.5, 2)]");
  expect_in(usd, "primvars:displayColor = [(0, 0, 0), (1, 1, 1)"); // linear light
  EXPECT_EQ(usd.find("timeSamples"), std::string::npos);
}

TEST_F(UsdTest, TheUpAxisAndUnitsAreThoseAskedForAndTheRootBringsThem) {
  write_meshes(table_.find("usd"), path(), {{"up", "z"}, {"units", "cm"}}, {triangle("a", 1)},
               {{"lost", "a \"word\" or two"}});
  const std::string usd = text();
  expect_in(usd, "metersPerUnit = 0.01\n");
  expect_in(usd, "upAxis = \"Z\"");
  expect_in(usd, "double xformOp:rotateX = -90\n    double3 xformOp:scale = (100, 100, 100)\n"
                 "    uniform token[] xformOpOrder = [\"xformOp:rotateX\", \"xformOp:scale\"]");
  expect_in(usd, "customLayerData = {\n        string lost = \"a \\\"word\\\" or two\"\n    }");
}

TEST_F(UsdTest, ARigidMeshHasATransformForEachFrame) {
  host::Mesh mesh = triangle("box", 0);
  mesh.skin.inverse_bind = {moved(-1)};
  host::MeshWriter writer = open();
  const std::size_t number = writer.add(mesh);
  for (int i = 0; i < 3; ++i) writer.pose(number, 0.04 * i, std::vector{moved(1 + i)});
  writer.finish();
  const std::string usd = text();
  expect_in(usd, "timeCodesPerSecond = 25");
  expect_in(usd, "endTimeCode = 2");
  expect_in(usd, "points = [(-1, 0, 2)"); // in the joint's space
  expect_in(
      usd,
      "translate.timeSamples = {\n            0: (1, 0, 0),\n            1: (2, 0, 0),\n            2: (3, 0, 0),");
  expect_in(usd, "orient.timeSamples = {\n            0: (1, 0, 0, 0),");
}

TEST_F(UsdTest, AHiddenMeshIsInvisible) {
  host::Mesh mesh = triangle("box", 0);
  mesh.skin.inverse_bind = {moved(0)};
  host::MeshWriter writer = open();
  const std::size_t number = writer.add(mesh);
  for (int i = 0; i < 3; ++i) writer.pose(number, 0.04 * i, std::vector{moved(i)}, i != 1);
  writer.finish();
  expect_in(text(), "token visibility.timeSamples = {\n            0: \"invisible\",\n            1: \"inherited\",\n"
                    "            2: \"invisible\",\n");
}

TEST_F(UsdTest, ASkinnedMeshHasItsPointsForEachFrame) {
  host::MeshWriter writer = open({{"fps", "50"}});
  const std::size_t number = writer.add(skinned());
  writer.pose(number, 0, std::vector{moved(0), moved(1)});
  writer.pose(number, 0.5, std::vector{moved(0), moved(3)});
  writer.finish();
  const std::string usd = text();
  expect_in(usd, "0: [(0, 0, 2), (0.1, 0, 2), (0, 0.5, 2)],");
  expect_in(usd, "25: [(0, 0, 2), (2.1, 0, 2), (1, 0.5, 2)],");
}

TEST_F(UsdTest, ATextureStandsBesideTheFile) {
  host::Mesh mesh = triangle("box", 0);
  mesh.colors.clear();
  mesh.texture = sample_color(8, 8, 3, 1);
  mesh.texture_coordinates = {{0, 0}, {1, 0}, {0, 0.25F}};
  write_meshes(table_.find("usd"), path(), {{"jpeg", "0"}}, {mesh});
  expect_in(text(), "asset inputs:file = @@@a clip_box.png@@@");
  expect_in(text(), "primvars:st = [(0, 1), (1, 1), (0, 0.75)]"); // from the lower left corner
  std::ifstream file(folder_.path() / "a clip_box.png", std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(file)), {});
  EXPECT_EQ(bytes, as_text(encode_png(mesh.texture)));
}

TEST_F(UsdTest, NamesThatWouldBeTheSameStayApart) {
  write_meshes(table_.find("usd"), path(), {}, {triangle("a b", 0), triangle("a.b", 0), triangle("1", 0)});
  for (const char* name : {"\"a_b\"", "\"a_b_2\"", "\"_1\""}) expect_in(text(), std::string("def Mesh ") + name);
}

TEST_F(UsdTest, WhatCannotBeWrittenIsAnError) {
  const auto code_of = [](const auto& call) {
    try {
      call();
    } catch (const Error& error) {
      return error.code();
    }
    return ErrorCode{};
  };
  EXPECT_EQ(code_of([&] { open().finish(); }), ErrorCode::kFailure);
  EXPECT_EQ(code_of([&] {
              host::MeshWriter writer = open();
              writer.add(skinned()); // and no pose
              writer.finish();
            }),
            ErrorCode::kFailure);
  EXPECT_EQ(code_of([&] { open({{"jpeg", "101"}}); }), ErrorCode::kUsage);
  EXPECT_EQ(code_of([&] { write_meshes(table_.find("usd"), "/dev/full", {}, {triangle("a", 0)}); }),
            ErrorCode::kUnwritableOutput);
}

} // namespace
} // namespace kinora::formats
