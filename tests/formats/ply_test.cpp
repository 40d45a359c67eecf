// PLY files, read back by the letter of the format.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include <Eigen/Geometry>

#include "core/error.h"
#include "formats/sample_capture.h"
#include "formats/sample_triangle.h"

namespace kinora::formats {
namespace {

using namespace kinora::test;

class PlyTest : public testing::Test {
protected:
  /// The file's head, and what follows it.
  std::pair<std::string, std::string> write(const std::vector<host::Mesh>& meshes, const host::Options& options = {}) {
    write_meshes(table_.find("ply"), folder_.path() / "a.ply", options, meshes);
    std::ifstream stream(folder_.path() / "a.ply", std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(stream)), {});
    const std::string end = "end_header\n";
    const std::size_t body = bytes.find(end) + end.size();
    return {bytes.substr(0, body), bytes.substr(body)};
  }
  template <class Value> static Value value_at(const std::string& body, std::size_t offset) {
    Value value{};
    std::memcpy(&value, body.data() + offset, sizeof value);
    return value;
  }

  static constexpr std::size_t kVertexBytes = 6 * 4 + 3;
  static constexpr std::size_t kFaceBytes = 1 + 3 * 4;
  TemporaryFolder folder_;
  host::PluginTable table_ = host::PluginTable::builtin();
};

TEST_F(PlyTest, AllMeshesBecomeOneListOfVerticesAndOneOfFaces) {
  const auto [head, body] = write({triangle("a", 0), triangle("b", 1)});
  EXPECT_TRUE(head.starts_with("ply\nformat binary_little_endian 1.0\n")) << head;
  EXPECT_NE(head.find("element vertex 6\nproperty float x\n"), std::string::npos) << head;
  EXPECT_NE(head.find("element face 2\nproperty list uchar int vertex_indices\n"), std::string::npos) << head;
  ASSERT_EQ(body.size(), 6 * kVertexBytes + 2 * kFaceBytes);
  const std::size_t second = 6 * kVertexBytes + kFaceBytes;
  EXPECT_EQ(body[second], 3);
  for (int k = 0; k < 3; ++k)
    EXPECT_EQ(value_at<std::int32_t>(body, second + 1 + 4 * static_cast<std::size_t>(k)), 3 + k);
}

TEST_F(PlyTest, VerticesLieWithYUpInTheirColours) {
  const std::string body = write({triangle("a", 1)}).second;
  const std::size_t last = 2 * kVertexBytes; // the vertex (1, 0.5, 2) with the normal (0, 0.6, -0.8)
  const float expected[] = {1, -0.5F, -2, 0, -0.6F, 0.8F};
  for (std::size_t i = 0; i < 6; ++i) EXPECT_FLOAT_EQ(value_at<float>(body, last + 4 * i), expected[i]) << i;
  EXPECT_EQ(value_at<std::uint8_t>(body, last + 24), 200);
  EXPECT_EQ(value_at<std::uint8_t>(body, last + 25), 100);
  EXPECT_EQ(value_at<std::uint8_t>(body, last + 26), 50);
}

TEST_F(PlyTest, TheUpAxisAndUnitsAreThoseAskedFor) {
  const auto [head, body] = write({triangle("a", 1)}, {{"up", "z"}, {"units", "cm"}});
  EXPECT_NE(head.find("comment Kinora: centimetres, x right, y forward, z up\n"), std::string::npos) << head;
  const float expected[] = {100, 200, -50, 0, -0.8F, -0.6F}; // the vertex (1, 0.5, 2) with the normal (0, 0.6, -0.8)
  for (std::size_t i = 0; i < 6; ++i)
    EXPECT_FLOAT_EQ(value_at<float>(body, 2 * kVertexBytes + 4 * i), expected[i]) << i;
}

TEST_F(PlyTest, CommentsSayHowTheFileWasMade) {
  write_meshes(table_.find("ply"), folder_.path() / "b.ply", {}, {triangle("a", 0)}, {{"lost", "one\ntwo"}});
  std::ifstream file(folder_.path() / "b.ply", std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(file)), {});
  EXPECT_NE(bytes.find("comment lost: one two\nelement vertex"), std::string::npos) << bytes.substr(0, 200);
}

TEST_F(PlyTest, PointsAreTheVerticesAlone) {
  const auto [head, body] = write({triangle("a", 0)}, {{"content", "points"}});
  EXPECT_EQ(head.find("element face"), std::string::npos) << head;
  EXPECT_EQ(body.size(), 3 * kVertexBytes);
  EXPECT_EQ(body, write({triangle("a", 0)}).second.substr(0, 3 * kVertexBytes));
}

// As the program of Kerbl et al. (2023) reads them: standard deviations as logarithms, opacity before the logistic
// function, colours as the harmonic of degree 0, in axes that are Kinora's too.
TEST_F(PlyTest, SplatsLieFlatOnTheSurfaceInItsColours) {
  const auto [head, body] = write({triangle("a", 1)}, {{"content", "splats"}});
  EXPECT_NE(head.find("property float f_dc_0\n"), std::string::npos) << head;
  EXPECT_NE(head.find("property float rot_3\nend_header\n"), std::string::npos) << head;
  ASSERT_EQ(body.size(), 3 * 17 * sizeof(float));
  const auto number = [&body = body](std::size_t vertex, std::size_t property) {
    return value_at<float>(body, sizeof(float) * (17 * vertex + property));
  };
  EXPECT_EQ(number(2, 1), 0.5F) << "y points down";
  const float red = 0.5F + 0.28209479F * number(2, 6);
  EXPECT_NEAR(red, 200 / 255.0, 1e-5);
  EXPECT_GT(1 / (1 + std::exp(-number(2, 9))), 0.9F);
  EXPECT_GT(std::exp(number(2, 10)), 0.1F);
  EXPECT_LT(std::exp(number(2, 10)), 0.5F) << "narrower than the triangle's longest side";
  EXPECT_LT(number(2, 12), number(2, 10) - 1) << "flat along its third axis";
  const Eigen::Quaternionf rotation(number(2, 13), number(2, 14), number(2, 15), number(2, 16));
  EXPECT_TRUE((rotation * Eigen::Vector3f::UnitZ()).isApprox(Eigen::Vector3f(0, 0.6F, -0.8F), 1e-5F));
}

TEST_F(PlyTest, FaultyMeshesAndUnwritablePlacesAreErrors) {
  const auto code_of = [&](const host::Mesh& mesh, const std::string& name) {
    try {
      write_meshes(table_.find("ply"), folder_.path() / name, {}, {mesh});
    } catch (const Error& error) {
      return error.code();
    }
    return ErrorCode{};
  };
  host::Mesh mesh = triangle("a", 0);
  EXPECT_EQ(code_of(mesh, "absent/a.ply"), ErrorCode::kUnwritableOutput);
  mesh.faces[0][2] = 3;
  EXPECT_EQ(code_of(mesh, "a.ply"), ErrorCode::kUsage);
  mesh = triangle("a", 0);
  mesh.colors.clear();
  EXPECT_EQ(code_of(mesh, "a.ply"), ErrorCode::kUsage);
}

} // namespace
} // namespace kinora::formats
