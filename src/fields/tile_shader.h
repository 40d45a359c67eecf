// Colours of surfaces: the field's features at a few points of each, and its colour net once for each pixel.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "fields/field_batch.h"
#include "fields/tile_marcher.h"

namespace kinora::fields {

/// Colours of the surfaces of one layer in a tile that are seen.
class TileShader {
public:
  /// `layer` must outlive this.
  explicit TileShader(const DrawableField::Derived& layer)
      : layer_(&layer), near_(kNear / static_cast<float>(layer.field.config.finest_resolution)) {}
  void clear() {
    for (std::vector<float>* values : {&x_, &y_, &z_, &weights_, &opacities_}) values->clear();
    rows_.clear();
    pixels_.clear();
  }
  /// Pixels in ascending order.
  void add(std::uint32_t pixel, const Surface& surface, float weight) {
    if (pixels_.empty() || pixels_.back() != pixel) {
      pixels_.push_back(pixel);
      opacities_.push_back(0);
    }
    opacities_.back() += weight;
    // Features hardly change there.
    const auto& s = surface.spread;
    if (s[0] * s[0] + s[1] * s[1] + s[2] * s[2] < near_ * near_) return add_point(surface, 0, weight);
    add_point(surface, -1, 0.5F * weight);
    add_point(surface, 1, 0.5F * weight);
  }
  void shade();

  const std::vector<std::uint32_t>& pixels() const { return pixels_; }
  float opacity(std::size_t row) const { return opacities_[row]; }
  std::array<float, 3> color(std::size_t row) const {
    std::array<float, 3> rgb{};
    for (std::size_t c = 0; c < 3; ++c)
      rgb[c] = 1.0F / (1.0F + std::exp(-color_.output[row * FieldConfig::kColorOutputs + c]));
    return rgb;
  }

private:
  void add_point(const Surface& surface, float side, float weight) {
    x_.push_back(surface.position[0] + side * surface.spread[0]);
    y_.push_back(surface.position[1] + side * surface.spread[1]);
    z_.push_back(surface.position[2] + side * surface.spread[2]);
    weights_.push_back(weight);
    rows_.push_back(static_cast<std::uint32_t>(pixels_.size() - 1));
  }

  const DrawableField::Derived* layer_;
  static constexpr float kNear = 0.75F;    // cells of the finest level
  float near_;                             // relative to the field's box
  std::vector<float> x_, y_, z_, weights_; // per point
  std::vector<std::uint32_t> rows_;        // per point
  std::vector<std::uint32_t> pixels_;      // per row
  std::vector<float> opacities_;           // per row
  PointBatch points_;
  ColorBatch color_;
};

} // namespace kinora::fields
