// How well tracks repeat a picture: what a later frame shows where the pixels of an earlier one are said to have gone.
// It judges tracks without any truth, and truths as well.
#pragma once

#include <cmath>
#include <limits>
#include <optional>

#include "ingest/frame/frame.h"
#include "tracking/view/texture.h"

namespace kinora::bench {

class PictureAgreement {
public:
  /// Both frames must outlive this; of one camera.
  PictureAgreement(const ingest::Frame& earlier, const ingest::Frame& later)
      : camera_(later.camera.intrinsics),
        shown_(tracking::log_luminance(earlier.color, 0, 0, camera_.width, camera_.height)),
        later_(tracking::log_luminance(later.color, 0, 0, camera_.width, camera_.height)),
        found_(camera_.width, camera_.height, 1, std::numeric_limits<float>::quiet_NaN()) {}

  /// Pixel (u, v) of the earlier frame is at `position` (metres, in the camera) in the later one.
  void add(int u, int v, const Eigen::Vector3d& position) {
    if (!(position.z() > 0)) return;
    const Eigen::Vector2d pixel = camera_.project(position);
    const double x = std::round(pixel.x());
    const double y = std::round(pixel.y());
    if (!(x >= 0 && y >= 0 && x < camera_.width && y < camera_.height)) return;
    found_.at(u, v) = later_.at(static_cast<int>(x), static_cast<int>(y));
  }

  /// Mean correlation of log luminance over squares of 15 × 15 pixels that were all added.
  double mean() const {
    double sum = 0;
    int count = 0;
    for (int v = kRadius; v + kRadius < found_.height(); v += kStep) {
      for (int u = kRadius; u + kRadius < found_.width(); u += kStep) {
        if (const auto value = correlation(u, v)) {
          sum += *value;
          ++count;
        }
      }
    }
    return sum / count;
  }

  /// The same around one pixel; nothing if the square leaves the picture, has no texture or was not all added.
  std::optional<double> correlation(int u, int v) const {
    if (!found_.contains(u - kRadius, v - kRadius) || !found_.contains(u + kRadius, v + kRadius)) return std::nullopt;
    double sums[5] = {};
    for (int y = v - kRadius; y <= v + kRadius; ++y) {
      for (int x = u - kRadius; x <= u + kRadius; ++x) {
        const double a = shown_.at(x, y);
        const double b = found_.at(x, y);
        sums[0] += a;
        sums[1] += b;
        sums[2] += a * a;
        sums[3] += b * b;
        sums[4] += a * b;
      }
    }
    constexpr double kPixels = (2 * kRadius + 1) * (2 * kRadius + 1);
    const double spread = (sums[2] - sums[0] * sums[0] / kPixels) * (sums[3] - sums[1] * sums[1] / kPixels);
    if (!(spread > 0)) return std::nullopt; // no texture, or a pixel that was not added
    return (sums[4] - sums[0] * sums[1] / kPixels) / std::sqrt(spread);
  }

private:
  static constexpr int kRadius = 7;
  static constexpr int kStep = 4;

  Intrinsics camera_;
  Image<float> shown_;
  Image<float> later_;
  Image<float> found_;
};

} // namespace kinora::bench
