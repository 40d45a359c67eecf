// What one frame shows of one label: a crop with depth, fitted planes and texture.
#pragma once

#include <algorithm>

#include "ingest/frame/frame.h"
#include "tracking/view/depth_planes.h"
#include "tracking/view/mask_area.h"
#include "tracking/view/silhouette.h"
#include "tracking/view/texture.h"

namespace kinora::tracking {

/// Value and gradient per crop pixel of the texture at a point.
struct TextureSample {
  float value;
  float du, dv;
};

/// Plain data; thread-safe to read. All images have the size of `intrinsics`, the camera's view cut to the crop.
struct LayerView {
  static constexpr int kLevels = kTextureLevels;

  Intrinsics intrinsics;
  DepthImage depth;                  ///< all measured depth in the crop: what may stand in front
  LabelImage mask;                   ///< values of MaskArea
  Image<std::int16_t> to_silhouette; ///< offsets to the nearest pixel of the label, or of one that may hide it;
                                     ///< empty: of a background, which goes on behind everything
  DepthPlanes planes;                ///< of the label's clean depth
  Image<float> texture;              ///< log luminance, slightly smoothed; its mean off the label
  TexturePyramid pyramid;
  LabelImage detail; ///< 1 where the texture is taken for what the layer wears, not for light; empty: everywhere
  ingest::DetectedJoints joints; ///< of the person, in pixels of the crop, if a detector has looked for them
  std::size_t depth_pixels = 0;  ///< pixels with a plane
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero(); ///< mean of their points, in the camera

  bool empty() const { return depth_pixels == 0; }
  /// The measured point of a crop pixel with a plane, on its ray.
  Eigen::Vector3d point(int u, int v) const;
  /// Texture at a point of the crop, in pixels; the caller has checked that it lies inside.
  TextureSample sample_texture(int level, double u, double v) const;
};

/// Cuts the bounding box of `label`, grown by a quarter. Empty if the frame has no labels or none of this label with
/// depth. Throws Error(kFailure) if the frame's images differ in size.
LayerView view_label(const ingest::Frame& frame, int label);

inline Eigen::Vector3d LayerView::point(int u, int v) const {
  const float* plane = planes.planes.pixel(u, v);
  const Eigen::Vector3d ray = intrinsics.unproject(u, v, 1.0);
  return ray * (-plane[3] / (plane[0] * ray.x() + plane[1] * ray.y() + plane[2]));
}

inline TextureSample LayerView::sample_texture(int level, double u, double v) const {
  const TextureLevel& texture_level = pyramid[static_cast<std::size_t>(level)];
  const Image<float>& image = texture_level.values;
  const float x = std::clamp((static_cast<float>(u) + 0.5F) * texture_level.scale - 0.5F, 0.0F,
                             static_cast<float>(image.width() - 1));
  const float y = std::clamp((static_cast<float>(v) + 0.5F) * texture_level.scale - 0.5F, 0.0F,
                             static_cast<float>(image.height() - 1));
  const int x0 = std::min(static_cast<int>(x), std::max(0, image.width() - 2));
  const int y0 = std::min(static_cast<int>(y), std::max(0, image.height() - 2));
  const float fx = x - static_cast<float>(x0);
  const float fy = y - static_cast<float>(y0);
  const float* a = image.pixel(x0, y0);
  const float* b = image.pixel(std::min(x0 + 1, image.width() - 1), y0);
  const float* c = image.pixel(x0, std::min(y0 + 1, image.height() - 1));
  const float* d = image.pixel(std::min(x0 + 1, image.width() - 1), std::min(y0 + 1, image.height() - 1));
  const auto mix = [&](int i) { return (a[i] * (1 - fx) + b[i] * fx) * (1 - fy) + (c[i] * (1 - fx) + d[i] * fx) * fy; };
  return {mix(0), mix(1), mix(2)};
}

} // namespace kinora::tracking
