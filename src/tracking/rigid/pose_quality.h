// How well a pose of a model explains a view.
#pragma once

#include <cstddef>
#include <span>

#include "tracking/rigid/residuals.h"

namespace kinora::tracking {

struct PoseQuality {
  std::size_t on_label = 0; ///< model points that face the camera and fall on a pixel of the label with depth
  std::size_t inliers = 0;  ///< of these, those within 3σ + 5 mm and 45°
  std::size_t free_space_violations = 0; ///< points that face the camera, but it sees past them beside the label
  double median_distance = 0;            ///< of |point-to-plane| over inliers, metres
  double texture_correlation = 0;        ///< of image and model, in [−1, 1]; 0 if there is too little texture to tell
  double explained_share = 0; ///< of the label's measured area, that which the model covers at about its depth

  double inlier_share() const {
    return on_label > 0 ? static_cast<double>(inliers) / static_cast<double>(on_label) : 0.0;
  }
  /// How far the model's silhouette leaves the label's.
  double free_space_share() const {
    if (free_space_violations == 0) return 0;
    return static_cast<double>(free_space_violations) / static_cast<double>(on_label + free_space_violations);
  }
  bool has_texture() const { return texture_correlation != 0; }
};

/// All zero without points or view. Thread-safe.
PoseQuality evaluate_pose(std::span<const ModelPoint> points, const LayerView& view, const SE3& model_to_camera);

} // namespace kinora::tracking
