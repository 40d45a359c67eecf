// What one frame shows of one label: a crop with depth, fitted planes and texture.
#pragma once

#include "ingest/frame.h"
#include "tracking/depth_planes.h"
#include "tracking/silhouette.h"
#include "tracking/texture.h"

namespace kinora::tracking {

/// Value and gradient per crop pixel of the texture at a point.
struct TextureSample {
  float value;
  float du, dv;
};

/// Plain data; thread-safe to read. All images have the size of `intrinsics`, the camera's view cut to the crop.
struct ObjectView {
  static constexpr int kLevels = kTextureLevels;

  Intrinsics intrinsics;
  DepthImage depth; ///< all measured depth in the crop: what may stand in front
  LabelImage mask;  ///< 1 where the label is, 2 where it is at least two pixels from the label's border
  Image<std::int16_t> to_silhouette; ///< offsets to the nearest pixel of the label, or of one that may hide it;
                                     ///< empty: of a background, which goes on behind everything
  DepthPlanes planes;                ///< of the label's clean depth
  Image<float> texture;              ///< log luminance, slightly smoothed; its mean off the label
  TexturePyramid pyramid;
  std::size_t depth_pixels = 0;                       ///< pixels with a plane
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero(); ///< mean of their points, in the camera

  bool empty() const { return depth_pixels == 0; }
  /// The measured point of a crop pixel with a plane, on its ray.
  Eigen::Vector3d point(int u, int v) const;
  /// Texture at a point of the crop, in pixels; the caller has checked that it lies inside.
  TextureSample sample_texture(int level, double u, double v) const;
};

/// Cuts the bounding box of `label`, grown by a quarter. Empty if the frame has no labels or none of this label with
/// depth. Throws Error(kFailure) if the frame's images differ in size.
ObjectView view_object(const ingest::Frame& frame, int label);

} // namespace kinora::tracking
