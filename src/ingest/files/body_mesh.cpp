#include "ingest/files/body_mesh.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "core/error.h"
#include "ingest/files/npz_archive.h"

namespace kinora::ingest {
namespace {

constexpr std::size_t kMaxVertices = 65536;
constexpr std::size_t kMaxFaces = 2 * kMaxVertices;
constexpr std::size_t kMaxJoints = 128;

class Reader {
public:
  explicit Reader(const std::filesystem::path& path) : path_(path.string()), archive_(path) {}

  BodyMesh read() {
    BodyMesh mesh;
    read_vertices(mesh);
    read_joint_tree();
    read_bones(mesh);
    read_joints(mesh);
    read_faces(mesh);
    return mesh;
  }

private:
  [[noreturn]] void refuse(const std::string& array, const std::string& what) const {
    throw Error(ErrorCode::kCorruptInput, fmt::format("{}, array {}: {}", path_, array, what));
  }

  // A matrix; nothing of a dimension is open: any number.
  NpyArray matrix(const std::string& name, std::optional<std::size_t> rows, std::optional<std::size_t> columns) {
    NpyArray array = archive_.read(name);
    const auto fits = [](std::size_t size, std::optional<std::size_t> wanted) { return !wanted || size == *wanted; };
    if (array.shape.size() != 2 || !fits(array.shape[0], rows) || !fits(array.shape[1], columns)) {
      const auto word = [](std::optional<std::size_t> n) { return n ? std::to_string(*n) : std::string("any"); };
      refuse(name, fmt::format("its shape is ({}), not ({}, {}); take all arrays from one model",
                               fmt::join(array.shape, ", "), word(rows), word(columns)));
    }
    return array;
  }

  void read_vertices(BodyMesh& mesh) {
    constexpr double kMinHeight = 0.4; // metres
    constexpr double kMaxHeight = 3;
    const NpyArray array = matrix("v_template", std::nullopt, 3);
    vertices_ = array.shape[0];
    if (vertices_ < 4 || vertices_ > kMaxVertices) {
      refuse("v_template",
             fmt::format("it has {} vertices, not 4 to {}; take a coarser mesh", vertices_, kMaxVertices));
    }
    double top = -1e300;
    double bottom = 1e300;
    for (std::size_t i = 0; i < vertices_; ++i) {
      mesh.vertices.emplace_back(array.values[3 * i], array.values[3 * i + 1], array.values[3 * i + 2]);
      top = std::max(top, mesh.vertices.back().y());
      bottom = std::min(bottom, mesh.vertices.back().y());
    }
    if (!(top - bottom >= kMinHeight && top - bottom <= kMaxHeight)) {
      refuse("v_template", fmt::format("the body is {:.3g} high, not {} to {} metres; give metres, y up", top - bottom,
                                       kMinHeight, kMaxHeight));
    }
  }

  // The first row says which joint is each one's parent; what the root's says differs between files.
  void read_joint_tree() {
    const NpyArray array = matrix("kintree_table", 2, std::nullopt);
    joints_ = array.shape[1];
    bool fits = joints_ >= kBodyMeshJoints && joints_ <= kMaxJoints;
    for (std::size_t j = 1; fits && j < kBodyMeshJoints; ++j) fits = array.values[j] == kBodyMeshParents.at(j);
    if (!fits) refuse("kintree_table", "its first 22 joints are not those of SMPL; bring them into SMPL's order");
  }

  void read_bones(BodyMesh& mesh) {
    constexpr double kSlack = 1e-3; // weights are stored as 32-bit floats by some
    const NpyArray array = matrix("weights", vertices_, joints_);
    for (std::size_t i = 0; i < vertices_; ++i) {
      const auto row = array.values.begin() + static_cast<std::ptrdiff_t>(i * joints_);
      const auto end = row + static_cast<std::ptrdiff_t>(joints_);
      double sum = 0;
      for (auto weight = row; weight != end; ++weight) sum += *weight;
      if (*std::min_element(row, end) < -kSlack || std::abs(sum - 1) > kSlack) {
        refuse("weights", fmt::format("those of vertex {} are not shares of one; normalise them", i));
      }
      mesh.bone.push_back(static_cast<std::size_t>(std::max_element(row, end) - row));
    }
  }

  void read_joints(BodyMesh& mesh) {
    constexpr double kMax = 3; // metres from the origin
    const NpyArray array = matrix("J_regressor", joints_, vertices_);
    for (std::size_t j = 0; j < kBodyMeshJoints; ++j) {
      mesh.joints.at(j).setZero();
      for (std::size_t i = 0; i < vertices_; ++i) {
        mesh.joints.at(j) += array.values[j * vertices_ + i] * mesh.vertices[i];
      }
      if (!(mesh.joints.at(j).cwiseAbs().maxCoeff() < kMax)) {
        refuse("J_regressor", fmt::format("it puts joint {} outside the body; take it from the mesh's own model", j));
      }
    }
  }

  void read_faces(BodyMesh& mesh) {
    const NpyArray array = matrix("f", std::nullopt, 3);
    if (array.shape[0] == 0 || array.shape[0] > kMaxFaces) {
      refuse("f", fmt::format("it has {} faces, not 1 to {}; take a coarser mesh", array.shape[0], kMaxFaces));
    }
    for (std::size_t i = 0; i < array.shape[0]; ++i) {
      std::array<std::size_t, 3> face;
      for (std::size_t c = 0; c < 3; ++c) {
        const double vertex = array.values[3 * i + c];
        if (!(vertex >= 0 && vertex < static_cast<double>(vertices_)) || vertex != std::floor(vertex)) {
          refuse("f", fmt::format("face {} names a vertex that there is not; take all arrays from one model", i));
        }
        face.at(c) = static_cast<std::size_t>(vertex);
      }
      mesh.faces.push_back(face);
    }
  }

  std::string path_;
  NpzArchive archive_;
  std::size_t vertices_ = 0, joints_ = 0;
};

} // namespace

BodyMesh read_body_mesh(const std::filesystem::path& path) { return Reader(path).read(); }

} // namespace kinora::ingest
