#include "player/picture_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kinora::player {
namespace {

std::uint8_t to_byte(float value) { return static_cast<std::uint8_t>(std::lrint(255 * std::clamp(value, 0.0F, 1.0F))); }

void paint(std::uint8_t* pixel, float red, float green, float blue) {
  pixel[0] = to_byte(red);
  pixel[1] = to_byte(green);
  pixel[2] = to_byte(blue);
}

void paint_depth(const fields::Picture& picture, ColorImage& out) {
  constexpr float kDarkest = 0.1F; // what is farthest is still told from nothing
  float nearest = std::numeric_limits<float>::max();
  float farthest = 0;
  for (const float depth : picture.depth.values()) {
    if (depth <= 0) continue;
    nearest = std::min(nearest, depth);
    farthest = std::max(farthest, depth);
  }
  const float range = std::max(1 / nearest - 1 / farthest, 1e-6F);
  for (std::size_t i = 0; i < picture.depth.pixel_count(); ++i) {
    const float depth = picture.depth.data()[i];
    const float grey = depth > 0 ? kDarkest + (1 - kDarkest) * (1 / depth - 1 / farthest) / range : 0;
    paint(out.data() + 4 * i, grey, grey, grey);
  }
}

void paint_normals(const fields::Picture& picture, ColorImage& out) {
  for (std::size_t i = 0; i < picture.depth.pixel_count(); ++i) {
    const float* n = picture.normal.data() + 3 * i;
    paint(out.data() + 4 * i, 0.5F + 0.5F * n[0], 0.5F - 0.5F * n[1], 0.5F - 0.5F * n[2]);
  }
}

void paint_confidence(const fields::Picture& picture, ColorImage& out) {
  for (std::size_t i = 0; i < picture.depth.pixel_count(); ++i) {
    const float seen = static_cast<float>(picture.confidence.data()[i]) / 255;
    paint(out.data() + 4 * i, 2 - 2 * seen, 2 * seen, 0);
  }
}

void paint_health(const fields::Picture& picture, const std::vector<motion::Health>& health, ColorImage& out) {
  for (std::size_t i = 0; i < picture.front.pixel_count(); ++i) {
    const std::size_t layer = picture.front.data()[i];
    if (layer == 0 || layer > health.size()) continue;
    std::uint8_t* pixel = out.data() + 4 * i;
    const float light = 0.3F + 0.7F * static_cast<float>(pixel[0] + pixel[1] + pixel[2]) / (3 * 255);
    const motion::Health of_layer = health[layer - 1];
    paint(pixel, of_layer == motion::Health::kTracked ? 0 : light, of_layer == motion::Health::kLost ? 0 : light, 0);
  }
}

} // namespace

fields::DrawOptions draw_options_for(PictureView view) {
  fields::DrawOptions options;
  options.normals = view == PictureView::kNormal;
  options.confidence = view == PictureView::kConfidence;
  return options;
}

ColorImage painted(const fields::Picture& picture, PictureView view, const std::vector<motion::Health>& health) {
  ColorImage out = picture.color;
  if (view == PictureView::kDepth) paint_depth(picture, out);
  if (view == PictureView::kNormal) paint_normals(picture, out);
  if (view == PictureView::kConfidence) paint_confidence(picture, out);
  if (view == PictureView::kHealth) paint_health(picture, health, out);
  return out;
}

} // namespace kinora::player
