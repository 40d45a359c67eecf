// OBJ files, read back by the letter of the format.
#include <gtest/gtest.h>

#include "core/error.h"
#include "formats/sample_capture.h"
#include "formats/sample_triangle.h"

namespace kinora::formats {
namespace {

using namespace kinora::test;

class ObjTest : public testing::Test {
protected:
  std::vector<std::string> write(const std::vector<host::Mesh>& meshes) {
    write_meshes(table_.find("obj"), folder_.path() / "a.obj", {}, meshes);
    std::ifstream file(folder_.path() / "a.obj");
    std::vector<std::string> lines;
    for (std::string line; std::getline(file, line);) lines.push_back(line);
    return lines;
  }
  TemporaryFolder folder_;
  host::PluginTable table_ = host::PluginTable::builtin();
};

TEST_F(ObjTest, EveryMeshIsAnObjectWithYUpAndColours) {
  const std::vector<std::string> expected{"# Kinora: metres, x right, y up, z backward",
                                          "o a",
                                          "v 1 0 -2 0 0 0",
                                          "v 1.1 0 -2 1 1 1",
                                          "v 1 -0.5 -2 0.7843 0.3922 0.1961",
                                          "vn 0 0 1",
                                          "vn 0 0 1",
                                          "vn 0 -0.6 0.8",
                                          "f 1//1 2//2 3//3"};
  EXPECT_EQ(write({triangle("a", 1)}), expected);
}

TEST_F(ObjTest, TheUpAxisAndUnitsAreThoseAskedFor) {
  write_meshes(table_.find("obj"), folder_.path() / "z.obj", {{"up", "z"}, {"units", "mm"}}, {triangle("a", 1)},
               {{"source", "clip.mkv"}});
  std::ifstream file(folder_.path() / "z.obj");
  const std::string text((std::istreambuf_iterator<char>(file)), {});
  EXPECT_TRUE(text.starts_with("# Kinora: millimetres, x right, y forward, z up\n# source: clip.mkv\no a\n")) << text;
  EXPECT_NE(text.find("v 1000 2000 -500 0.7843"), std::string::npos) << text;
  EXPECT_NE(text.find("vn 0 -0.8 -0.6"), std::string::npos) << text;
}

TEST_F(ObjTest, VerticesAreNumberedThroughAllMeshes) {
  EXPECT_EQ(write({triangle("a", 0), triangle("b", 0)}).back(), "f 4//4 5//5 6//6");
}

TEST_F(ObjTest, FaultyMeshesAndUnwritablePlacesAreErrors) {
  host::Mesh mesh = triangle("a", 0);
  mesh.faces[0][2] = 3;
  EXPECT_THROW(write({mesh}), Error);
  EXPECT_THROW(write_meshes(table_.find("obj"), folder_.path() / "absent/a.obj", {}, {triangle("a", 0)}), Error);
}

TEST_F(ObjTest, WithoutAnyMeshHasNoVertices) {
  for (const std::string& line : write({})) EXPECT_NE(line.substr(0, 2), "v ");
}

} // namespace
} // namespace kinora::formats
