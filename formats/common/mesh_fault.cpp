#include "common/mesh_fault.h"

#include <algorithm>
#include <cmath>

namespace kinora::formats {
namespace {

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

} // namespace

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
  if (mesh.texture.data != nullptr) {
    if (mesh.texture_coordinates == nullptr || !all_finite(mesh.texture_coordinates, 2 * mesh.vertex_count))
      return "it has a texture and no finite texture coordinates";
    if (mesh.texture.pixel_type != KINORA_PIXEL_U8 || mesh.texture.channels != 3)
      return "its texture is not of 8 bits and 3 channels";
  }
  if (mesh.joint_count == 0) return {};
  if (mesh.joint_count > kMaxJoints || mesh.inverse_bind == nullptr ||
      !all_finite(mesh.inverse_bind, 16 * mesh.joint_count))
    return "its joints are too many, or without finite bind matrices";
  if ((mesh.joint_indices == nullptr) != (mesh.joint_weights == nullptr) ||
      (mesh.joint_indices == nullptr && mesh.joint_count != 1))
    return "it has joints, but not both their numbers and their weights";
  return mesh.joint_indices != nullptr ? fault_of_weights(mesh) : "";
}

std::string fault_of_colored(const KinoraMesh& mesh) {
  if (std::string fault = fault_of(mesh); !fault.empty()) return fault;
  if (mesh.joint_count > 0) return "it has joints, which a file of one time does not hold";
  if (mesh.colors == nullptr || mesh.normals == nullptr) return "its vertices have no colours or no normals";
  return {};
}

} // namespace kinora::formats
