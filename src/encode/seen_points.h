// What stored frames show of a label, and what other stored frames show where that should be.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "fields/sampling/pixel_map.h"

namespace kinora::encode {

using Color = std::array<std::uint8_t, 3>;

struct SeenPoint {
  Eigen::Vector3d world; ///< metres
  Color color;
};

/// Those that have a measured pixel of the label, in their order.
std::vector<const fields::StoredFrame*> frames_showing(const fields::PixelStore& pixels, int label);

/// The label's measured pixels in a stored frame: all, or about 2000 of them, spread evenly.
std::vector<SeenPoint> points_of(const fields::PixelStore& pixels, const fields::StoredFrame& frame, int label);

/// Whether colours are alike: 16 of 255 apart, in the mean of their channels.
bool is_like(const Color& a, const Color& b);

/// One stored frame, asked for what it shows of the world. The store must outlive it.
class StoredPicture {
public:
  enum class Look : std::uint8_t {
    kNotKept, ///< the pixel is not stored
    kNothing, ///< outside the picture, not measured, or something stands before it
    kThere,   ///< a surface is where the point is, within what a sensor tells
    kBehind   ///< the picture sees past it
  };
  struct Shown {
    Look look = Look::kNothing;
    Color color{};           ///< if there or behind
    std::int64_t pixel = -1; ///< in the picture, row by row; −1 outside
  };

  StoredPicture(const fields::PixelStore& pixels, const fields::StoredFrame& frame);

  Shown at(const Eigen::Vector3d& world) const;
  /// Of the picture's pixels.
  double kept_share() const { return kept_share_; }

private:
  fields::PixelMap map_;
  Intrinsics intrinsics_;
  SE3 world_to_camera_;
  double kept_share_;
};

} // namespace kinora::encode
