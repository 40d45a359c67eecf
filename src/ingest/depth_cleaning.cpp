#include "ingest/depth_cleaning.h"

#include "ingest/sensor_noise.h"

namespace kinora::ingest {
namespace {

/// The slope of a surface at each pixel, from neighbours of the same row or column that no jump separates.
class Cleaner {
public:
  Cleaner(const DepthImage& depth, const Intrinsics& intrinsics, const DepthCleaning& limits)
      : depth_(depth), intrinsics_(intrinsics), limits_(limits), jump_(depth.width(), depth.height()),
        left_(depth.width(), depth.height()), right_(depth.width(), depth.height()),
        above_(depth.width(), depth.height()), below_(depth.width(), depth.height()) {}

  DepthImage run() {
    mark_steps();
    DepthImage kept(depth_.width(), depth_.height());
    for (int v = 0; v < depth_.height(); ++v)
      for (int u = 0; u < depth_.width(); ++u)
        if (depth_.at(u, v) > 0 && jump_.at(u, v) == 0 && !grazing(u, v)) kept.at(u, v) = depth_.at(u, v);
    return eroded(kept);
  }

private:
  /// True if a surface goes on from (u, v) to its neighbour; marks both if there is a jump between them.
  bool joined(int u, int v, int next_u, int next_v) {
    const float a = depth_.at(u, v);
    const float b = depth_.at(next_u, next_v);
    if (a <= 0 || b <= 0) return false;
    const double z = std::min(a, b);
    const double limit = std::max(limits_.max_jump * z, limits_.max_jump_sigmas * depth_sigma(z));
    if (std::abs(a - b) <= limit) return true;
    jump_.at(u, v) = jump_.at(next_u, next_v) = 1;
    return false;
  }

  /// Fills in the jumps, and how many joined steps lead from each pixel in each direction.
  void mark_steps() {
    const int width = depth_.width();
    const int height = depth_.height();
    const auto longer = [this](std::uint8_t reach) {
      return static_cast<std::uint8_t>(std::min<int>(reach + 1, limits_.slope_radius));
    };
    for (int v = 0; v < height; ++v) {
      for (int u = 1; u < width; ++u)
        if (joined(u - 1, v, u, v)) left_.at(u, v) = longer(left_.at(u - 1, v));
      for (int u = width - 1; u > 0; --u)
        if (left_.at(u, v) > 0) right_.at(u - 1, v) = longer(right_.at(u, v));
    }
    for (int v = 1; v < height; ++v)
      for (int u = 0; u < width; ++u)
        if (joined(u, v - 1, u, v)) above_.at(u, v) = longer(above_.at(u, v - 1));
    for (int v = height - 1; v > 0; --v)
      for (int u = 0; u < width; ++u)
        if (above_.at(u, v) > 0) below_.at(u, v - 1) = longer(below_.at(u, v));
  }

  /// Least-squares slope of depth per pixel at `z[0]`, over `behind` and `ahead` neighbours along `stride`.
  static float slope(const float* z, std::ptrdiff_t stride, int behind, int ahead) {
    if (behind == ahead) { // the usual case: the mean of x vanishes
      float sum_xz = 0, sum_xx = 0;
      for (int x = 1; x <= ahead; ++x) {
        const auto fx = static_cast<float>(x);
        sum_xz += fx * (z[x * stride] - z[-x * stride]);
        sum_xx += 2 * fx * fx;
      }
      return ahead > 0 ? sum_xz / sum_xx : 0;
    }
    const float count = static_cast<float>(behind + ahead + 1);
    float sum_x = 0, sum_z = 0, sum_xx = 0, sum_xz = 0;
    for (int x = -behind; x <= ahead; ++x) {
      const auto fx = static_cast<float>(x);
      sum_x += fx;
      sum_z += z[x * stride];
      sum_xx += fx * fx;
      sum_xz += fx * z[x * stride];
    }
    return (count * sum_xz - sum_x * sum_z) / (count * sum_xx - sum_x * sum_x);
  }

  /// With z(u, v) the depth at a pixel, the normal is (fx·z_u, fy·z_v, −z − (u−cx)·z_u − (v−cy)·z_v) up to length, and
  /// its product with the ray ((u−cx)/fx, (v−cy)/fy, 1) is −z.
  bool grazing(int u, int v) const {
    const float* at = depth_.pixel(u, v);
    const double z = *at;
    const double z_u = slope(at, 1, left_.at(u, v), right_.at(u, v));
    const double z_v = slope(at, depth_.width(), above_.at(u, v), below_.at(u, v));
    const double x = u - intrinsics_.cx;
    const double y = v - intrinsics_.cy;
    const Eigen::Vector3d normal(intrinsics_.fx * z_u, intrinsics_.fy * z_v, -z - x * z_u - y * z_v);
    const Eigen::Vector3d ray(x / intrinsics_.fx, y / intrinsics_.fy, 1);
    return z * z < square_of_min_sine_ * normal.squaredNorm() * ray.squaredNorm();
  }

  static DepthImage eroded(const DepthImage& kept) {
    DepthImage result = kept;
    for (int v = 0; v < kept.height(); ++v) {
      for (int u = 0; u < kept.width(); ++u) {
        const bool border = (u > 0 && kept.at(u - 1, v) <= 0) || (u + 1 < kept.width() && kept.at(u + 1, v) <= 0) ||
                            (v > 0 && kept.at(u, v - 1) <= 0) || (v + 1 < kept.height() && kept.at(u, v + 1) <= 0);
        if (border) result.at(u, v) = 0;
      }
    }
    return result;
  }

  const DepthImage& depth_;
  const Intrinsics& intrinsics_;
  const DepthCleaning& limits_;
  const double square_of_min_sine_ = std::sin(limits_.min_incidence) * std::sin(limits_.min_incidence);
  Image<std::uint8_t> jump_; ///< 1 on both sides of a jump
  /// Number of joined steps in each direction, at most `slope_radius`.
  Image<std::uint8_t> left_, right_, above_, below_;
};

} // namespace

DepthImage clean_depth(const DepthImage& depth, const Intrinsics& intrinsics, const DepthCleaning& limits) {
  return Cleaner(depth, intrinsics, limits).run();
}

} // namespace kinora::ingest
