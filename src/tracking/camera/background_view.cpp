#include "tracking/camera/background_view.h"

#include <algorithm>
#include <array>

#include "core/error.h"
#include "core/parallel.h"
#include "ingest/frame/pixel_blocks.h"

namespace kinora::tracking {
namespace {

constexpr int kGeometryWidth = 160;
constexpr int kTextureWidth = 320;
constexpr std::size_t kRowsPerChunk = 16;

constexpr int factor_to(int width, int from) { return (from + width - 1) / width; }

bool is_background(const LabelImage& labels, int left, int top, int factor) {
  for (int v = top; v < top + factor; ++v) {
    const std::uint8_t* row = labels.pixel(left, v);
    if (std::any_of(row, row + factor, [](std::uint8_t label) { return label != 0; })) return false;
  }
  return true;
}

void check_sizes(const ingest::Frame& frame) {
  const Intrinsics& k = frame.camera.intrinsics;
  const auto fits = [&k](const auto& image) { return image.width() == k.width && image.height() == k.height; };
  if (!fits(frame.color) || !fits(frame.clean_depth) || (frame.has_labels() && !fits(frame.labels)) ||
      frame.color.channels() < 3) {
    throw Error(ErrorCode::kFailure, "frame " + std::to_string(frame.index) +
                                         " has images of different sizes; colour, depth and labels must be registered");
  }
}

// Of what is background, all that has only background in the 5×5 around.
void mark_interior(LabelImage& mask) {
  const LabelImage outer = mask;
  for (int v = 2; v + 2 < mask.height(); ++v) {
    for (int u = 2; u + 2 < mask.width(); ++u) {
      bool inside = true;
      for (int dv = -2; dv <= 2 && inside; ++dv) {
        const std::uint8_t* row = outer.pixel(u - 2, v + dv);
        inside = std::all_of(row, row + 5, [](std::uint8_t m) { return m != MaskArea::kOutside; });
      }
      if (inside) mask.at(u, v) = MaskArea::kInterior;
    }
  }
}

} // namespace

BackgroundFrame reduce_background(const ingest::Frame& frame) {
  check_sizes(frame);
  const Intrinsics& k = frame.camera.intrinsics;
  const int finer = factor_to(kTextureWidth, k.width);
  const int ratio = k.width <= kGeometryWidth ? 1 : 2; // pixels of colour to one of depth
  const int factor = finer * ratio;
  const int width = std::max(1, k.width / factor);
  const int height = std::max(1, k.height / factor);
  const double middle = 0.5 * (factor - 1);
  BackgroundFrame reduced{
      frame.time,
      {width, height, k.fx / factor, k.fy / factor, (k.cx - middle) / factor, (k.cy - middle) / factor},
      DepthImage(width, height),
      LabelImage(width, height, 1, 1),
      ColorImage(width * ratio, height * ratio, 3)};
  const auto is_any = [](int, int) { return true; };
  parallel_for(static_cast<std::size_t>(height), kRowsPerChunk, [&](const Chunk& rows) {
    for (int v = static_cast<int>(rows.begin); v < static_cast<int>(rows.end); ++v) {
      for (int u = 0; u < width; ++u) {
        reduced.depth.at(u, v) = ingest::mean_depth(frame.clean_depth, u * factor, v * factor, factor, is_any);
        if (!frame.has_labels() || is_background(frame.labels, u * factor, v * factor, factor)) continue;
        reduced.mask.at(u, v) = 0;
      }
      for (int y = v * ratio; y < (v + 1) * ratio; ++y) {
        for (int x = 0; x < width * ratio; ++x) {
          ingest::mean_color(frame.color, x * finer, y * finer, finer, reduced.color.pixel(x, y));
        }
      }
    }
  });
  return reduced;
}

LayerView view_background(const BackgroundFrame& frame) {
  LayerView view;
  view.intrinsics = frame.intrinsics;
  view.mask = frame.mask;
  mark_interior(view.mask);
  view.depth = frame.depth;
  view.planes = fit_depth_planes(frame.depth, frame.intrinsics, frame.mask);
  const auto weights = view.planes.weights.values();
  view.depth_pixels =
      static_cast<std::size_t>(std::count_if(weights.begin(), weights.end(), [](float w) { return w > 0; }));
  if (view.empty()) return view;
  const int ratio = frame.color.width() / frame.depth.width();
  Image<float> luminance = log_luminance(frame.color, 0, 0, frame.color.width(), frame.color.height());
  LabelImage mask(luminance.width(), luminance.height());
  for (int v = 0; v < mask.height(); ++v) {
    for (int u = 0; u < mask.width(); ++u) mask.at(u, v) = frame.mask.at(u / ratio, v / ratio);
  }
  fill_outside(luminance, mask);
  view.pyramid = texture_pyramid(luminance, static_cast<float>(ratio));
  return view;
}

} // namespace kinora::tracking
