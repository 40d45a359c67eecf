// What a mesh's vertices carry, in the numbers that glTF counts them in.
#pragma once

#include <cstdint>
#include <vector>

#include "kinora/plugin.h"

namespace kinora::formats {

enum class VertexOrder {
  kGiven,
  kDrawing ///< in which triangles need them: packs and draws well
};

/// A mesh that follows one joint is in that joint's space.
struct MeshAttributes {
  /// The mesh must be without fault (mesh_data.h).
  MeshAttributes(const KinoraMesh& mesh, VertexOrder vertex_order);

  std::size_t vertex_count() const { return positions.size() / 3; }

  std::vector<float> positions;       ///< 3 per vertex, metres
  std::vector<float> normals;         ///< 3 per vertex, or none
  std::vector<std::uint16_t> colors;  ///< linear red, green, blue and 1, in 1/65535; or none
  std::vector<float> texture;         ///< 2 per vertex: shares of the picture's width and height; or none
  std::vector<std::uint16_t> joints;  ///< 4 per vertex, or none
  std::vector<std::uint16_t> weights; ///< 4 per vertex, in 1/65535, of which they are the sum; or none
  std::vector<std::uint32_t> faces;   ///< 3 per triangle
  std::vector<std::uint32_t> order;   ///< where each vertex that was given stands here
};

/// Rows of `width` values that are given for each vertex, as they stand in `mesh`.
std::vector<float> in_order_of(const MeshAttributes& mesh, const std::vector<float>& rows, std::size_t width);

/// 0 … 1 in 1/65535.
std::uint16_t whole_share(float share);

/// sRGB byte to linear light in 0…65535 (IEC 61966-2-1), which is what COLOR_0 holds.
std::uint16_t linear_color(std::uint8_t srgb);

} // namespace kinora::formats
