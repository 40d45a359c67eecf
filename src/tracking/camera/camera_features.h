// Small pieces of surface that a view can be known again by, and where two views stand to each other by them.
// Sources: Shi and Tomasi, "Good Features to Track", CVPR 1994 (where); Wu et al., "3D Model Matching with
// Viewpoint-Invariant Patches (VIP)", CVPR 2008 (what: texture on the surface's own plane, at its true size); Fischler
// and Bolles, "Random Sample Consensus", CACM 1981 (which belong together).
#pragma once

#include <cstddef>
#include <optional>

#include "core/se3.h"
#include "tracking/view/layer_view.h"

namespace kinora::tracking {

/// Pieces of surface, by columns. Plain data; thread-safe to read.
struct SurfaceFeatures {
  static constexpr int kSide = 8; ///< samples of a piece, each way

  Eigen::Matrix3Xf positions;  ///< in the camera, metres
  Eigen::MatrixXf descriptors; ///< kSide² rows: log luminance; mean 0, length 1
  Eigen::Index count() const { return descriptors.cols(); }
};

/// At most kMaxFeatures, fairly over the picture: corners of the texture on surface that is seen well. `camera_to_map`
/// tells which way pieces are turned: views are known again if it is right to about 20°. `size`: of a piece, metres.
SurfaceFeatures find_features(const LayerView& view, const Eigen::Matrix3d& camera_to_map, double size);

/// How many features are each other's likeliest, and alike: a guess whether both views show the same place.
std::size_t count_matches(const SurfaceFeatures& a, const SurfaceFeatures& b);

/// The pose b → a by which more of the like features lie upon each other than chance would have it, to a few
/// centimetres; nothing without one. Deterministic.
std::optional<SE3> register_by_features(const SurfaceFeatures& a, const SurfaceFeatures& b);

} // namespace kinora::tracking
