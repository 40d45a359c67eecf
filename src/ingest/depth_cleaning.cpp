#include "ingest/depth_cleaning.h"

#include "ingest/sensor_noise.h"

namespace kinora::ingest {
namespace {

/// Works on rows with the steps to the next pixel to the right and below marked once as joined or not.
class Cleaner {
public:
  Cleaner(const DepthImage& depth, const Intrinsics& intrinsics, const DepthCleaning& limits)
      : depth_(depth), intrinsics_(intrinsics), limits_(limits), right_(depth.width(), depth.height()),
        below_(depth.width(), depth.height()) {}

  DepthImage run() {
    mark_joints();
    DepthImage kept(depth_.width(), depth_.height());
    for (int v = 0; v < depth_.height(); ++v)
      for (int u = 0; u < depth_.width(); ++u)
        if (depth_.at(u, v) > 0 && !at_jump(u, v) && !grazing(u, v)) kept.at(u, v) = depth_.at(u, v);
    return eroded(kept);
  }

private:
  enum Joint : std::uint8_t { kMissing, kJump, kJoined };

  Joint joint(float a, float b) const {
    if (a <= 0 || b <= 0) return kMissing;
    const double z = std::min(a, b);
    const double limit = std::max(limits_.max_jump * z, limits_.max_jump_sigmas * depth_sigma(z));
    return std::abs(a - b) > limit ? kJump : kJoined;
  }

  void mark_joints() {
    for (int v = 0; v < depth_.height(); ++v) {
      for (int u = 0; u + 1 < depth_.width(); ++u) right_.at(u, v) = joint(depth_.at(u, v), depth_.at(u + 1, v));
      if (v + 1 == depth_.height()) break;
      for (int u = 0; u < depth_.width(); ++u) below_.at(u, v) = joint(depth_.at(u, v), depth_.at(u, v + 1));
    }
  }

  bool at_jump(int u, int v) const {
    return right_.at(u, v) == kJump || below_.at(u, v) == kJump || (u > 0 && right_.at(u - 1, v) == kJump) ||
           (v > 0 && below_.at(u, v - 1) == kJump);
  }

  /// Least-squares slope of depth per pixel at `values[0]`, over at most `slope_radius` joined neighbours on both
  /// sides along `stride`; `ahead` and `behind` limit the reach at the image's border.
  float slope(const float* values, const std::uint8_t* joints, std::ptrdiff_t stride, int behind, int ahead) const {
    float count = 1, sum_x = 0, sum_z = values[0], sum_xx = 0, sum_xz = 0;
    const auto add = [&](int x) {
      const float z = values[x * stride];
      const auto fx = static_cast<float>(x);
      count += 1;
      sum_x += fx;
      sum_z += z;
      sum_xx += fx * fx;
      sum_xz += fx * z;
    };
    for (int x = 0; x < std::min(ahead, limits_.slope_radius) && joints[x * stride] == kJoined; ++x) add(x + 1);
    for (int x = 1; x <= std::min(behind, limits_.slope_radius) && joints[-x * stride] == kJoined; ++x) add(-x);
    const float spread = count * sum_xx - sum_x * sum_x;
    return spread > 0 ? (count * sum_xz - sum_x * sum_z) / spread : 0;
  }

  /// With z(u, v) the depth at a pixel, the normal is (fx·z_u, fy·z_v, −z − (u−cx)·z_u − (v−cy)·z_v) up to length, and
  /// its product with the ray ((u−cx)/fx, (v−cy)/fy, 1) is −z.
  bool grazing(int u, int v) const {
    const float* z = depth_.pixel(u, v);
    const int width = depth_.width();
    const double z_u = slope(z, right_.pixel(u, v), 1, u, width - 1 - u);
    const double z_v = slope(z, below_.pixel(u, v), width, v, depth_.height() - 1 - v);
    const double x = u - intrinsics_.cx;
    const double y = v - intrinsics_.cy;
    const Eigen::Vector3d normal(intrinsics_.fx * z_u, intrinsics_.fy * z_v, -*z - x * z_u - y * z_v);
    const Eigen::Vector3d ray(x / intrinsics_.fx, y / intrinsics_.fy, 1);
    const double sine = *z / std::sqrt(normal.squaredNorm() * ray.squaredNorm());
    return sine < sin_min_incidence_;
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
  const double sin_min_incidence_ = std::sin(limits_.min_incidence);
  Image<std::uint8_t> right_; ///< Joint of a pixel with the next one in its row
  Image<std::uint8_t> below_; ///< Joint of a pixel with the next one in its column
};

} // namespace

DepthImage clean_depth(const DepthImage& depth, const Intrinsics& intrinsics, const DepthCleaning& limits) {
  return Cleaner(depth, intrinsics, limits).run();
}

} // namespace kinora::ingest
