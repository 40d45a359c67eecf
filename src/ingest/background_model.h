// What stays where it is, as one still camera sees it.
#pragma once

#include <span>

#include "ingest/plane_finder.h"
#include "ingest/segmentation_view.h"
#include "ingest/surface_components.h"

namespace kinora::ingest {

enum class Ground : std::uint8_t { kBackground, kForeground, kUnmeasured };

/// Per pixel of the view the farthest depth that was measured again and again, and its colour. Surfaces that waver
/// there (a person who never leaves) are no background. Thread-safe once it is made.
class BackgroundModel {
public:
  /// From views of one camera at different times, all of one size; at least one.
  explicit BackgroundModel(std::span<const SegmentationView> samples);

  /// Metres; 0: nothing is known; infinity: nothing is measured there unless something stands in front.
  const DepthImage& depth() const { return depth_; }
  /// Only where `has_color` is 1.
  const ColorImage& color() const { return color_; }
  const Mask& has_color() const { return has_color_; }
  const std::vector<Plane>& planes() const { return planes_; }
  /// Share of the measured pixels whose background was found and keeps still: small if the camera moves.
  double still_share() const { return still_share_; }

  /// Where a measurement at pixel (u, v) of the model stands. `point` is it in space, z = 0 if there is none.
  Ground ground_of(int u, int v, const Eigen::Vector3d& point) const;
  /// The same for a whole view.
  Image<Ground> ground_of(const SegmentationView& view) const;
  /// Largest difference of a channel to the background's colour, −1 if that is not known.
  int color_difference(int u, int v, const std::uint8_t* color) const;

private:
  void find_farthest_stable(std::span<const SegmentationView> samples);
  SurfaceComponents surfaces_off_planes() const;
  void drop_wavering_planes(std::span<const SegmentationView> samples);
  void drop_wavering(std::span<const SegmentationView> samples);
  void drop_what_hangs_on_foreground(std::span<const SegmentationView> samples);
  void find_colors(std::span<const SegmentationView> samples);
  bool on_plane(const Eigen::Vector3d& point) const;

  Intrinsics intrinsics_;
  DepthImage depth_;
  ColorImage color_;
  Mask has_color_;
  std::vector<Plane> planes_;
  double still_share_ = 0;
};

} // namespace kinora::ingest
