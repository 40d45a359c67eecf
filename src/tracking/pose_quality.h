// How well a pose of a model explains a view.
#pragma once

#include <cstddef>
#include <span>

#include "tracking/residuals.h"

namespace kinora::tracking {

struct PoseQuality {
  std::size_t on_label = 0;       ///< model points that face the camera and fall on a pixel of the label with depth
  std::size_t inliers = 0;        ///< of these, those within 3σ + 5 mm and 45°
  std::size_t outside = 0;        ///< points that face the camera beside the label, where nothing measured hides them
  double median_distance = 0;     ///< of |point-to-plane| over inliers, metres
  double texture_correlation = 0; ///< of image and model, in [−1, 1]; 0 if there is too little texture to tell
  double explained_share = 0;     ///< of the label's measured area, that which the model covers at about its depth

  double inlier_share() const {
    return on_label > 0 ? static_cast<double>(inliers) / static_cast<double>(on_label) : 0.0;
  }
  /// How far the model's silhouette leaves the label's.
  double outside_share() const {
    return outside > 0 ? static_cast<double>(outside) / static_cast<double>(on_label + outside) : 0.0;
  }
  bool has_texture() const { return texture_correlation != 0; }
};

/// All zero without points or view. Thread-safe.
PoseQuality judge_pose(std::span<const ModelPoint> points, const ObjectView& view, const SE3& model_to_camera);

} // namespace kinora::tracking
