// What a field shows along rays, and how that changes when the layer moves beneath them: what motion is aligned by.
#pragma once

#include <array>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "fields/model/field.h"
#include "fields/network/vector_features.h"

namespace kinora::fields {

/// A ray about a surface, in canonical space: point + t · direction + t² · bends[t > 0] for |t| ≤ reach.
struct CanonicalRay {
  Eigen::Vector3d point; ///< metres
  Eigen::Vector3d direction;
  std::array<Eigen::Vector3d, 2> curvatures;
  double reach;
  double metres_per_t;
  Rotation rotation; ///< of the layer
};

struct RayResponse {
  static constexpr std::size_t kColors = 3;
  static constexpr std::size_t kOpacity = 3;
  static constexpr std::size_t kDepth = 4; ///< t of the surface
  static constexpr std::size_t kValues = 5;

  std::array<double, kValues> value{}; ///< red, green, blue in [0, 1], opacity, depth
  /// Derivative by a displacement of the ray, per metre; zero for colour and depth beside what is not opaque.
  std::array<Eigen::Vector3d, kValues> jacobian{};
  bool is_opaque = false; ///< at the ray and about it; else colour and depth mean nothing
};

/// Compositing as in training, over a few samples in occupied space; derivatives, if wanted, by central differences of
/// a cell. Writes responses[i] for rays[i]. Thread-safe.
void respond(const Field& field, std::span<const GridLevel> levels, std::span<const CanonicalRay> rays, bool jacobian,
             RayResponse* responses);

} // namespace kinora::fields
