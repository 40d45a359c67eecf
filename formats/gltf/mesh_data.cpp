#include "gltf/mesh_data.h"

#include <cmath>

#include <Eigen/Geometry>

namespace kinora::formats {
namespace {

using RowMajorMatrix = Eigen::Matrix<float, 4, 4, Eigen::RowMajor>;

constexpr std::size_t kMaxJoints = 65536;

bool all_finite(const float* values, std::size_t count) {
  return std::all_of(values, values + count, [](float v) { return std::isfinite(v); });
}

std::string fault_of_weights(const KinoraMesh& mesh) {
  constexpr float kTolerance = 1e-3F;
  for (std::size_t v = 0; v < mesh.vertex_count; ++v) {
    float sum = 0;
    for (std::size_t k = 4 * v; k < 4 * v + 4; ++k) {
      if (mesh.joint_indices[k] >= mesh.joint_count) return "a vertex names a joint that is not there";
      if (!(mesh.joint_weights[k] >= 0)) return "a vertex has a weight that is negative or no number";
      sum += mesh.joint_weights[k];
    }
    if (!(std::abs(sum - 1) < kTolerance)) return "the weights of a vertex do not add up to 1";
  }
  return {};
}

/// Weights in 1/65535 that add up to it; the first of the largest takes what rounding leaves.
std::vector<std::uint16_t> whole_weights(const KinoraMesh& mesh) {
  constexpr int kOne = 65535;
  std::vector<std::uint16_t> weights(4 * mesh.vertex_count);
  for (std::size_t v = 0; v < mesh.vertex_count; ++v) {
    const float* given = mesh.joint_weights + 4 * v;
    int left = kOne;
    for (std::size_t k = 0; k < 4; ++k) {
      weights[4 * v + k] = static_cast<std::uint16_t>(std::lround(std::min(given[k], 1.0F) * kOne));
      left -= weights[4 * v + k];
    }
    const auto largest = static_cast<std::size_t>(std::max_element(given, given + 4) - given);
    weights[4 * v + largest] = static_cast<std::uint16_t>(weights[4 * v + largest] + left);
  }
  return weights;
}

std::vector<std::uint16_t> linear_colors(const KinoraMesh& mesh) {
  std::vector<std::uint16_t> colors;
  colors.reserve(4 * mesh.vertex_count);
  for (std::size_t v = 0; v < mesh.vertex_count; ++v) {
    for (std::size_t c = 0; c < 3; ++c) colors.push_back(linear_color(mesh.colors[3 * v + c]));
    colors.push_back(65535); // opaque; three numbers alone would not be aligned
  }
  return colors;
}

} // namespace

std::uint16_t linear_color(std::uint8_t srgb) {
  const double value = srgb / 255.0;
  const double linear = value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
  return static_cast<std::uint16_t>(std::lround(linear * 65535));
}

std::string fault_of(const KinoraMesh& mesh) {
  if (mesh.name == nullptr || mesh.vertex_count == 0 || mesh.face_count == 0 || mesh.positions == nullptr ||
      mesh.faces == nullptr)
    return "it has no name, no vertices or no faces";
  if (mesh.vertex_count > 0xFFFFFFFEU) return "it has more vertices than 32 bits can number";
  if (!all_finite(mesh.positions, 3 * mesh.vertex_count) ||
      (mesh.normals != nullptr && !all_finite(mesh.normals, 3 * mesh.vertex_count)))
    return "a vertex is not at finite numbers";
  for (std::size_t i = 0; i < 3 * mesh.face_count; ++i)
    if (mesh.faces[i] >= mesh.vertex_count) return "a face names a vertex that is not there";
  if (mesh.joint_count == 0) return {};
  if (mesh.joint_count > kMaxJoints || mesh.inverse_bind == nullptr ||
      !all_finite(mesh.inverse_bind, 16 * mesh.joint_count))
    return "its joints are too many, or without finite bind matrices";
  if ((mesh.joint_indices == nullptr) != (mesh.joint_weights == nullptr) ||
      (mesh.joint_indices == nullptr && mesh.joint_count != 1))
    return "it has joints, but not both their numbers and their weights";
  return mesh.joint_indices != nullptr ? fault_of_weights(mesh) : "";
}

nlohmann::json add_mesh(GlbBuffer& buffer, const KinoraMesh& mesh) {
  const bool is_rigid = mesh.joint_count == 1 && mesh.joint_indices == nullptr;
  const Eigen::Affine3f bind(is_rigid ? RowMajorMatrix(Eigen::Map<const RowMajorMatrix>(mesh.inverse_bind))
                                      : RowMajorMatrix::Identity());
  std::vector<float> positions(3 * mesh.vertex_count);
  std::vector<float> normals;
  for (std::size_t v = 0; v < mesh.vertex_count; ++v)
    Eigen::Map<Eigen::Vector3f>(positions.data() + 3 * v) =
        bind * Eigen::Map<const Eigen::Vector3f>(mesh.positions + 3 * v);
  nlohmann::json attributes = {
      {"POSITION", buffer.add(std::span<const float>(positions), kGlbPositions, GlbTarget::kVertices)}};
  if (mesh.normals != nullptr) {
    normals.resize(3 * mesh.vertex_count);
    for (std::size_t v = 0; v < mesh.vertex_count; ++v)
      Eigen::Map<Eigen::Vector3f>(normals.data() + 3 * v) =
          (bind.linear() * Eigen::Map<const Eigen::Vector3f>(mesh.normals + 3 * v)).normalized();
    attributes["NORMAL"] = buffer.add(std::span<const float>(normals), kGlbVectors, GlbTarget::kVertices);
  }
  if (mesh.colors != nullptr) {
    const std::vector<std::uint16_t> colors = linear_colors(mesh);
    attributes["COLOR_0"] = buffer.add(std::span<const std::uint16_t>(colors), kGlbShares, GlbTarget::kVertices);
  }
  if (mesh.joint_indices != nullptr) {
    const std::vector<std::uint16_t> weights = whole_weights(mesh);
    std::vector<std::uint16_t> joints(mesh.joint_indices, mesh.joint_indices + 4 * mesh.vertex_count);
    for (std::size_t i = 0; i < joints.size(); ++i)
      if (weights[i] == 0) joints[i] = 0; // rounding may have made it an unused one
    attributes["JOINTS_0"] = buffer.add(std::span<const std::uint16_t>(joints), kGlbNumbers, GlbTarget::kVertices);
    attributes["WEIGHTS_0"] = buffer.add(std::span<const std::uint16_t>(weights), kGlbShares, GlbTarget::kVertices);
  }
  const int faces = buffer.add(std::span(mesh.faces, 3 * mesh.face_count), kGlbIndices, GlbTarget::kIndices);
  nlohmann::json primitive = {{"attributes", std::move(attributes)}, {"indices", faces}, {"material", 0}};
  return {{"name", mesh.name}, {"primitives", {std::move(primitive)}}};
}

} // namespace kinora::formats
