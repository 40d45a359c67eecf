#include "tracking/object_view.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/error.h"

namespace kinora::tracking {
namespace {

struct Box {
  int u0, v0, u1, v1; ///< end excluded
  bool empty() const { return u0 >= u1; }
};

Box bounding_box(const LabelImage& labels, int label) {
  Box box{labels.width(), labels.height(), 0, 0};
  for (int v = 0; v < labels.height(); ++v) {
    const std::uint8_t* row = labels.pixel(0, v);
    for (int u = 0; u < labels.width(); ++u) {
      if (row[u] != label) continue;
      box = {std::min(box.u0, u), std::min(box.v0, v), std::max(box.u1, u + 1), v + 1};
    }
  }
  return box;
}

Box grown(const Box& box, int width, int height) {
  const int margin = 8 + std::max(box.u1 - box.u0, box.v1 - box.v0) / 4;
  return {std::max(0, box.u0 - margin), std::max(0, box.v0 - margin), std::min(width, box.u1 + margin),
          std::min(height, box.v1 + margin)};
}

// 1 on the label, 2 where the 5×5 around lies on it entirely.
LabelImage cut_mask(const LabelImage& labels, int label, const Box& box) {
  LabelImage mask(box.u1 - box.u0, box.v1 - box.v0);
  for (int v = 0; v < mask.height(); ++v) {
    for (int u = 0; u < mask.width(); ++u) mask.at(u, v) = labels.at(box.u0 + u, box.v0 + v) == label ? 1 : 0;
  }
  LabelImage inner = mask;
  for (int v = 2; v + 2 < mask.height(); ++v) {
    for (int u = 2; u + 2 < mask.width(); ++u) {
      bool inside = true;
      for (int dv = -2; dv <= 2 && inside; ++dv) {
        for (int du = -2; du <= 2 && inside; ++du) inside = mask.at(u + du, v + dv) != 0;
      }
      if (inside) inner.at(u, v) = 2;
    }
  }
  return inner;
}

// Binomial 3×3 over the pixels of the mask.
Image<float> smoothed(const Image<float>& values, const LabelImage& mask) {
  Image<float> result(values.width(), values.height());
  for (int v = 0; v < values.height(); ++v) {
    for (int u = 0; u < values.width(); ++u) {
      if (mask.at(u, v) == 0) continue;
      float sum = 0;
      float weights = 0;
      for (int dv = -1; dv <= 1; ++dv) {
        for (int du = -1; du <= 1; ++du) {
          if (!mask.contains(u + du, v + dv) || mask.at(u + du, v + dv) == 0) continue;
          const float w = (du == 0 ? 2.0F : 1.0F) * (dv == 0 ? 2.0F : 1.0F);
          sum += w * values.at(u + du, v + dv);
          weights += w;
        }
      }
      result.at(u, v) = sum / weights;
    }
  }
  return result;
}

template <class T> Image<T> cut(const Image<T>& image, const Box& box) {
  Image<T> result(box.u1 - box.u0, box.v1 - box.v0);
  for (int v = 0; v < result.height(); ++v) {
    std::copy_n(image.pixel(box.u0, box.v0 + v), result.width(), result.pixel(0, v));
  }
  return result;
}

void check_sizes(const ingest::Frame& frame) {
  const Intrinsics& camera = frame.camera.intrinsics;
  const auto fits = [&camera](const auto& image) {
    return image.width() == camera.width && image.height() == camera.height;
  };
  if (!fits(frame.color) || !fits(frame.depth) || !fits(frame.clean_depth) ||
      (!frame.labels.empty() && !fits(frame.labels)) || frame.color.channels() < 3) {
    throw Error(ErrorCode::kFailure, "frame " + std::to_string(frame.index) +
                                         " has images of different sizes; colour, depth and labels must be registered");
  }
}

void measure_depth(ObjectView& view) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int v = 0; v < view.mask.height(); ++v) {
    for (int u = 0; u < view.mask.width(); ++u) {
      if (view.planes.weights.at(u, v) <= 0) continue;
      sum += view.point(u, v);
      ++view.depth_pixels;
    }
  }
  if (view.depth_pixels > 0) view.centroid = sum / static_cast<double>(view.depth_pixels);
}

} // namespace

Eigen::Vector3d ObjectView::point(int u, int v) const {
  const float* plane = planes.planes.pixel(u, v);
  const Eigen::Vector3d ray = intrinsics.unproject(u, v, 1.0);
  return ray * (-plane[3] / (plane[0] * ray.x() + plane[1] * ray.y() + plane[2]));
}

TextureSample ObjectView::sample_texture(int level, double u, double v) const {
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

ObjectView view_object(const ingest::Frame& frame, int label) {
  check_sizes(frame);
  ObjectView view;
  if (frame.labels.empty()) return view;
  const Box tight = bounding_box(frame.labels, label);
  if (tight.empty()) return view;
  const Box box = grown(tight, frame.labels.width(), frame.labels.height());
  view.intrinsics = frame.camera.intrinsics;
  view.intrinsics.width = box.u1 - box.u0;
  view.intrinsics.height = box.v1 - box.v0;
  view.intrinsics.cx -= box.u0;
  view.intrinsics.cy -= box.v0;
  view.mask = cut_mask(frame.labels, label, box);
  view.to_silhouette = offsets_to_silhouette(cut(frame.labels, box)); // another label may hide this one
  view.depth = cut(frame.depth, box);
  view.planes = fit_depth_planes(cut(frame.clean_depth, box), view.intrinsics, view.mask);
  measure_depth(view);
  if (view.empty()) return view;
  view.texture = smoothed(log_luminance(frame.color, box.u0, box.v0, view.mask.width(), view.mask.height()), view.mask);
  fill_outside(view.texture, view.mask);
  view.pyramid = texture_pyramid(view.texture, 1);
  return view;
}

} // namespace kinora::tracking
