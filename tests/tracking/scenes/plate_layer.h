// A deforming layer that is a plate, as its parts see it: the canonical model of the plate's first frame, before views
// of others.
#pragma once

#include <vector>

#include "bending_plate.h"
#include "tracking/deforming/model_in_view.h"
#include "tracking/view/deforming_view.h"

namespace kinora::tracking::testing {

/// The camera stands at the world's origin.
inline ingest::Frame frame_of(const Plate& plate) {
  SceneOptions options;
  options.width = 160;
  options.height = 120;
  options.focal = 160;
  return render_plate(plate, SE3::Identity(), 0, options);
}

/// A small plate at `centre`, turned about its y axis.
inline Plate small_plate(const Eigen::Vector3d& centre, double degrees = 0) {
  Plate plate;
  plate.half_width = 0.15;
  plate.half_height = 0.12;
  plate.to_world = pose_at(centre, 0, degrees);
  return plate;
}

inline SE3 shift(double x, double y, double z) { return SE3(Eigen::Translation3d(x, y, z)); }

struct PlateLayer {
  explicit PlateLayer(const Plate& plate)
      : frame(frame_of(plate)), view(view_layer(frame, 2)),
        model(CanonicalModel::from_view(view, SE3::Identity()).value()) {}

  ingest::Frame frame;
  LayerView view;
  CanonicalModel model;
  LayerBinding binding;
  ModelInViewConfig config;

  ModelInView in(const LayerView& other) const {
    return {model, other, SE3::Identity(), binding.constraints(model, 0, SE3::Identity()), config};
  }
  /// Transforms of all nodes, relative to the origin, when the plate goes on by `motion` in the world.
  std::vector<SE3> moved_by(const SE3& motion) const {
    const Eigen::Translation3d origin(model.origin());
    return std::vector<SE3>(model.nodes().size(), SE3(origin.inverse() * motion * origin));
  }
};

} // namespace kinora::tracking::testing
