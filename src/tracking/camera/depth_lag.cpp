#include "tracking/camera/depth_lag.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Cholesky>

#include "core/velocity.h"
#include "tracking/rigid/rigid_icp.h"

namespace kinora::tracking {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr std::size_t kMaxPoints = 600; // about
constexpr double kTextureAlone = 1e4;   // the weight with which depth hardly matters
constexpr double kLeast = 0.002;        // seconds
constexpr double kMost = 0.1;
constexpr double kDeviations = 4;
constexpr std::size_t kStretches = 8; // that the frames are cut into
constexpr std::size_t kMinFrames = 6; // of each

/// The same motion, seen from where `transform` leads.
Twist carried(const SE3& transform, const Twist& twist) {
  const Eigen::Vector3d turn = transform.linear() * twist.tail<3>();
  Twist result;
  result << transform.linear() * twist.head<3>() + transform.translation().cross(turn), turn;
  return result;
}

/// What one frame says about the lag.
struct FrameLag {
  double seconds;
  double weight; ///< one over its standard deviation
};

// What depth of a lag would differ by for each second of it: by the frame's motion, less that of the key frame, whose
// texture lies beside its points likewise.
std::optional<FrameLag> lag_of(const LagEvidence& frame, std::span<const SE3> path, std::span<const double> times) {
  const Twist shift = velocity_at(frame.frame, path, times) -
                      carried(frame.keyframe_to_camera, velocity_at(frame.keyframe, path, times));
  const Twist weighted = frame.measured.certainty * shift;
  const double information = shift.dot(weighted);
  if (!std::isfinite(information) || !(information > 0)) return std::nullopt;
  return FrameLag{weighted.dot(frame.measured.difference) / information, std::sqrt(information)};
}

// Where the sum of weighted distances is least.
double weighted_median(std::vector<FrameLag> lags) {
  std::sort(lags.begin(), lags.end(), [](const FrameLag& a, const FrameLag& b) { return a.seconds < b.seconds; });
  double left = 0;
  for (const FrameLag& lag : lags) left += lag.weight / 2;
  for (const FrameLag& lag : lags) {
    left -= lag.weight;
    if (left <= 0) return lag.seconds;
  }
  return lags.back().seconds;
}

} // namespace

DepthAgainstTexture depth_against_texture(std::span<const ModelPoint> points, const LayerView& view,
                                          const SE3& model_to_camera) {
  std::vector<ModelPoint> visible;
  const std::size_t stride = 1 + points.size() / kMaxPoints;
  for (std::size_t i = 0; i < points.size(); i += stride) {
    if (project(points[i], view, model_to_camera)) visible.push_back(points[i]);
  }
  AlignmentConfig config;
  config.coarsest_level = 1;
  const auto aligned = [&](double photometric_weight) {
    config.photometric_weight = photometric_weight;
    return align(visible, view, model_to_camera, model_to_camera, {}, config).model_to_camera;
  };
  const SE3 by_depth = aligned(0);
  const SE3 by_texture = aligned(kTextureAlone);
  const Matrix6 depth = information_at(visible, view, by_depth).depth;
  const Matrix6 texture = information_at(visible, view, by_texture).texture;
  return {log_se3(by_depth * by_texture.inverse()), depth * (depth + texture).ldlt().solve(texture)};
}

std::optional<double> estimate_depth_lag(std::span<const LagEvidence> evidence, std::span<const SE3> path,
                                         std::span<const double> times) {
  std::vector<FrameLag> lags;
  for (const LagEvidence& frame : evidence) {
    if (const auto lag = lag_of(frame, path, times)) lags.push_back(*lag);
  }
  if (lags.size() < kStretches * kMinFrames) return std::nullopt;
  const double lag = weighted_median(lags);
  double squares = 0;
  for (std::size_t s = 0; s < kStretches; ++s) {
    const auto begin = lags.begin() + static_cast<std::ptrdiff_t>(s * lags.size() / kStretches);
    const auto end = lags.begin() + static_cast<std::ptrdiff_t>((s + 1) * lags.size() / kStretches);
    const double difference = weighted_median({begin, end}) - lag;
    squares += difference * difference;
  }
  const double deviation = std::sqrt(squares / (kStretches - 1) / kStretches);
  if (!(std::abs(lag) > std::max(kLeast, kDeviations * deviation)) || std::abs(lag) > kMost) return std::nullopt;
  return lag;
}

} // namespace kinora::tracking
