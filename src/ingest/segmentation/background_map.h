// What stays where it is in the world, as a camera sees it from wherever it goes.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "ingest/segmentation/background_model.h"

namespace kinora::ingest {

/// Background models at a few places along the camera's path, each made of all samples as they are seen from there
/// (reproject). A still camera has one place, and its samples are what they are. Thread-safe once it is made.
class BackgroundMap {
public:
  /// From views at different times, all of one size, that know where their camera was; at least one.
  explicit BackgroundMap(std::span<const ReducedView> samples);

  /// As in BackgroundModel, over all places: small if the camera was not where it is said to have been.
  double static_share() const;
  /// Else hardly anything does, and the map tells nothing.
  bool keeps_still() const { return static_share() >= 0.35; }

private:
  friend class LocalBackground;
  struct KeyView {
    SE3 camera_to_world;
    BackgroundModel model;
  };
  std::vector<KeyView> key_views_;
};

/// The map from where one camera stands. The map must outlive it. Thread-safe.
class LocalBackground {
public:
  LocalBackground(const BackgroundMap& map, const Intrinsics& intrinsics, const SE3& camera_to_world);
  LocalBackground(const BackgroundMap& map, const ReducedView& view)
      : LocalBackground(map, view.intrinsics, view.camera_to_world) {}

  /// Where a point in the camera's space stands, z ≤ 0 if it is none. The nearest place decides that knows it; what it
  /// takes for foreground must not be on a still surface as another place sees it. What no place knows is background.
  Ground ground_of(const Eigen::Vector3d& point) const;
  /// The same for each pixel of a view from there.
  Image<Ground> ground_of(const ReducedView& view) const;
  /// Whether a foreground point is more than a still surface's edge beside its place, as the places that know it see
  /// it.
  bool is_clear_foreground(const Eigen::Vector3d& point) const;
  /// Whether depth was ever measured in the direction of a point in the camera's space.
  bool ever_measured(const Eigen::Vector3d& point) const;
  /// Largest difference of a channel to the background's colour behind pixel (u, v); nothing if that is not known.
  std::optional<int> color_difference(int u, int v, const std::uint8_t* color) const;

private:
  struct Near {
    const BackgroundModel* model;
    SE3 from_camera;
    SE3 to_camera;
  };
  Intrinsics intrinsics_;
  std::vector<Near> near_; ///< the nearest place first
};

} // namespace kinora::ingest
