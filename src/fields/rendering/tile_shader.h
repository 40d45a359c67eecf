// Colours of surfaces: the field's features at a few points of each, and its colour net once for each pixel.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "fields/network/field_batch.h"
#include "fields/rendering/tile_marcher.h"

namespace kinora::fields {

/// Colours of the surfaces of one layer in a tile that are seen.
class TileShader {
public:
  /// `layer` must outlive this.
  explicit TileShader(const DrawableField::Derived& layer)
      : layer_(&layer), near_(kNear / static_cast<float>(layer.field.config.finest_resolution)) {}
  void clear() {
    count_ = 0;
    opacities_.clear();
    rotations_.clear();
    max_weights_.clear();
    pixels_.clear();
  }
  /// Pixels in ascending order.
  void add(std::uint32_t pixel, const Surface& surface, float weight) {
    if (pixels_.empty() || pixels_.back() != pixel) {
      pixels_.push_back(pixel);
      opacities_.push_back(0);
      rotations_.push_back(surface.rotation);
      max_weights_.push_back(0);
    }
    if (weight > max_weights_.back()) {
      max_weights_.back() = weight;
      rotations_.back() = surface.rotation;
    }
    opacities_.back() += weight;
    // Features hardly change there.
    const auto& s = surface.sigma;
    if (s[0] * s[0] + s[1] * s[1] + s[2] * s[2] < near_ * near_) return add_point(surface, 0, weight);
    add_point(surface, -1, 0.5F * weight);
    add_point(surface, 1, 0.5F * weight);
  }
  void shade();

  const std::vector<std::uint32_t>& pixels() const { return pixels_; }
  float opacity(std::size_t row) const { return opacities_[row]; }
  /// sRGB; the fourth means nothing.
  Eigen::Map<const Eigen::Array4f> color(std::size_t row) const {
    return Eigen::Map<const Eigen::Array4f>(colors_.data() + 4 * row);
  }

private:
  void add_point(const Surface& surface, float side, float weight) {
    for (std::size_t a = 0; a < 3; ++a) points_->at[a][count_] = surface.position[a] + side * surface.sigma[a];
    points_->weight[count_] = weight;
    points_->row[count_++] = static_cast<std::uint32_t>(pixels_.size() - 1);
  }

  static constexpr std::size_t kMaxPoints = 2 * Surfaces::kPixels * Surfaces::kMaxPerPixel;
  struct Points {
    std::array<std::array<float, kMaxPoints>, 3> at; // relative to the field's box
    std::array<float, kMaxPoints> weight;
    std::array<std::uint32_t, kMaxPoints> row;
  };

  const DrawableField::Derived* layer_;
  static constexpr float kNear = 0.75F;        // cells of the finest level
  float near_;                                 // relative to the field's box
  std::unique_ptr<Points> points_{new Points}; // without initial values
  std::size_t count_ = 0;                      // points
  std::vector<std::uint32_t> pixels_;          // per row
  std::vector<float> opacities_;               // per row
  std::vector<Rotation> rotations_;            // per row, of the surface that weighs most
  std::vector<float> max_weights_;             // per row: what that weighs
  PointBatch batch_;
  ColorBatch color_;
  std::vector<float> colors_; // rows × 4
};

} // namespace kinora::fields
