// What stays where it is, as a camera sees it from one place.
#pragma once

#include <optional>
#include <span>

#include "ingest/frame/reduced_view.h"
#include "ingest/images/plane_finder.h"
#include "ingest/images/surface_components.h"

namespace kinora::ingest {

enum class Ground : std::uint8_t { kBackground, kForeground, kUnmeasured, kUnknown };

/// Per pixel of the view the farthest depth that was measured again and again, and its colour. Surfaces that waver
/// there (a person who never leaves) are no background. Thread-safe once it is made.
class BackgroundModel {
public:
  /// From views of one camera at different times, all of one size; at least one. Where few views tell, nothing is
  /// known.
  /// `slack`: pixels by which a still surface may be beside its place from one view to another.
  explicit BackgroundModel(std::span<const ReducedView> samples, int slack = 0);

  const Intrinsics& intrinsics() const { return intrinsics_; }
  /// Metres; 0: nothing keeps still there; infinity: nothing is measured there unless something stands in front.
  const DepthImage& depth() const { return depth_; }
  /// 1 where anything was ever measured.
  const Mask& measured() const { return measured_; }
  /// Share of the measured pixels whose background was found and keeps still: small if the camera moves.
  double static_share() const { return static_share_; }

  /// Where a measurement at pixel (u, v) of the model stands. `point` is it in space, z ≤ 0 if there is none.
  /// kUnknown if too few views saw the pixel.
  Ground ground_of(int u, int v, const Eigen::Vector3d& point) const;
  /// Whether a point that is foreground is so clearly: the model has a surface where the view that saw it farthest off
  /// has it, and another view may be off to the other side, so that a still surface's edge is up to twice the slack and
  /// a pixel's fraction beside its place.
  bool is_clear_foreground(int u, int v, const Eigen::Vector3d& point) const;
  /// Whether a point is on a surface that keeps still, as this place sees it at pixel (u, v).
  bool is_on_background(int u, int v, const Eigen::Vector3d& point) const;
  /// Largest difference of a channel to the background's colour; nothing if that is not known.
  std::optional<int> color_difference(int u, int v, const std::uint8_t* color) const;

private:
  void find_farthest_stable(std::span<const ReducedView> samples);
  SurfaceComponents surfaces_off_planes() const;
  void drop_high_variance_planes(std::span<const ReducedView> samples);
  void drop_high_variance(std::span<const ReducedView> samples);
  void drop_connected_to_foreground(std::span<const ReducedView> samples);
  void find_colors(std::span<const ReducedView> samples);
  Image<Ground> ground_of(const ReducedView& view) const;
  /// The background's colour; nullptr if it is not known.
  const std::uint8_t* still_color(int u, int v) const;
  bool on_plane(const Eigen::Vector3d& point) const;
  float nearest_within(int u, int v, int reach) const;
  bool in_front(int u, int v, const Eigen::Vector3d& point, int reach) const;

  int slack_;
  Intrinsics intrinsics_;
  DepthImage depth_;
  ColorImage color_;
  Mask has_color_;
  Mask known_;
  Mask measured_;
  std::vector<Plane> planes_;
  double static_share_ = 0;
};

} // namespace kinora::ingest
