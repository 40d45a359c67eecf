#include "gltf/mesh_attributes.h"

#include <cmath>
#include <numeric>
#include <span>

#include <Eigen/Geometry>
#include <meshoptimizer.h>

#include "core/linear_light.h"

namespace kinora::formats {
namespace {

using RowMajorMatrix = Eigen::Matrix<float, 4, 4, Eigen::RowMajor>;

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

/// Rows of `width` values in the order of `remap`.
template <class Value>
std::vector<Value> ordered(const std::vector<Value>& rows, std::size_t width, std::span<const std::uint32_t> remap) {
  std::vector<Value> out(rows.size());
  for (std::size_t v = 0; v < rows.size() / width; ++v)
    std::copy_n(rows.begin() + static_cast<std::ptrdiff_t>(v * width), width,
                out.begin() + static_cast<std::ptrdiff_t>(remap[v] * width));
  return out;
}

/// Vertices and triangles in an order in which neighbours are near each other, which packs and draws well. Those that
/// no triangle has come last.
std::vector<std::uint32_t> drawing_order(std::vector<std::uint32_t>& faces, std::size_t vertices) {
  const std::vector<std::uint32_t> given = faces;
  meshopt_optimizeVertexCache(faces.data(), given.data(), given.size(), vertices);
  std::vector<std::uint32_t> remap(vertices);
  auto next =
      static_cast<std::uint32_t>(meshopt_optimizeVertexFetchRemap(remap.data(), faces.data(), faces.size(), vertices));
  for (std::uint32_t& to : remap) {
    if (to == ~0U) to = next++;
  }
  for (std::uint32_t& v : faces) v = remap[v];
  return remap;
}

} // namespace

std::vector<float> in_order_of(const MeshAttributes& mesh, const std::vector<float>& rows, std::size_t width) {
  return ordered(rows, width, mesh.order);
}

std::uint16_t linear_color(std::uint8_t srgb) {
  return static_cast<std::uint16_t>(std::lround(linear_light(srgb / 255.0) * 65535));
}

std::uint16_t whole_share(float share) {
  return static_cast<std::uint16_t>(std::lround(65535 * std::clamp(share, 0.0F, 1.0F)));
}

MeshAttributes::MeshAttributes(const KinoraMesh& mesh, VertexOrder vertex_order)
    : faces(mesh.faces, mesh.faces + 3 * mesh.face_count) {
  order.resize(mesh.vertex_count);
  std::iota(order.begin(), order.end(), 0U);
  if (vertex_order == VertexOrder::kDrawing) order = drawing_order(faces, mesh.vertex_count);
  const bool is_rigid = mesh.joint_count == 1 && mesh.joint_indices == nullptr;
  const Eigen::Affine3f bind(is_rigid ? RowMajorMatrix(Eigen::Map<const RowMajorMatrix>(mesh.inverse_bind))
                                      : RowMajorMatrix::Identity());
  positions.resize(3 * mesh.vertex_count);
  if (mesh.normals != nullptr) normals.resize(3 * mesh.vertex_count);
  for (std::size_t v = 0; v < mesh.vertex_count; ++v) {
    const std::size_t to = 3 * order[v];
    Eigen::Map<Eigen::Vector3f>(positions.data() + to) =
        bind * Eigen::Map<const Eigen::Vector3f>(mesh.positions + 3 * v);
    if (mesh.normals == nullptr) continue;
    Eigen::Map<Eigen::Vector3f>(normals.data() + to) =
        (bind.linear() * Eigen::Map<const Eigen::Vector3f>(mesh.normals + 3 * v)).normalized();
  }
  if (mesh.colors != nullptr) {
    colors.resize(4 * mesh.vertex_count, 65535); // opaque; three numbers alone would not be aligned
    for (std::size_t v = 0; v < mesh.vertex_count; ++v) {
      for (std::size_t c = 0; c < 3; ++c) colors[4 * order[v] + c] = linear_color(mesh.colors[3 * v + c]);
    }
  }
  if (mesh.texture.data != nullptr) {
    texture = ordered(std::vector<float>(mesh.texture_coordinates, mesh.texture_coordinates + 2 * mesh.vertex_count), 2,
                      order);
  }
  if (mesh.joint_indices == nullptr) return;
  weights = ordered(whole_weights(mesh), 4, order);
  joints =
      ordered(std::vector<std::uint16_t>(mesh.joint_indices, mesh.joint_indices + 4 * mesh.vertex_count), 4, order);
  for (std::size_t i = 0; i < joints.size(); ++i) {
    if (weights[i] == 0) joints[i] = 0; // rounding may have made it an unused one
  }
}

} // namespace kinora::formats
