#include "tracking/deforming/pose_search.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel.h"
#include "core/statistics.h"
#include "tracking/view/visibility.h"

namespace kinora::tracking {
namespace {

constexpr std::size_t kRowsPerChunk = 2;

/// A model point as it is in the camera.
struct Sample {
  Eigen::Vector3d position;
  double brightness;
};

std::vector<Sample> samples_of(const LayerModel& model, std::span<const PointTexture> textures,
                               const motion::NodeStates& states, std::size_t max_count) {
  std::vector<Sample> samples;
  const std::size_t stride = std::max<std::size_t>(1, model.points.size() / std::max<std::size_t>(1, max_count));
  for (std::size_t p = 0; p < model.points.size(); p += stride) {
    const motion::SkinnedPoint& point = model.points[p];
    samples.push_back({motion::blend_motion(states, point.influence()).apply(point.position.cast<double>()),
                       static_cast<double>(textures[p].fused)});
  }
  return samples;
}

class ShiftCost {
public:
  ShiftCost(const LayerView& view, const PoseSearchConfig& config) : view_(view), config_(config) {}

  /// Depth measured behind a place, or 0.
  double depth_at(const Eigen::Vector3d& position, int& u, int& v) const {
    if (!(position.z() > kNearestDepth)) return 0;
    const Eigen::Vector2d pixel = view_.intrinsics.project(position);
    if (!is_in_picture(pixel.x(), pixel.y(), view_.intrinsics)) return 0;
    u = static_cast<int>(std::lround(pixel.x()));
    v = static_cast<int>(std::lround(pixel.y()));
    return view_.planes.weights.at(u, v) > 0 ? view_.point(u, v).z() : 0.0;
  }

  double cost(std::span<const Sample> samples, const Eigen::Vector3d& shift) const {
    if (samples.empty()) return 1;
    double sum = 0;
    for (const Sample& sample : samples) {
      const Eigen::Vector3d position = sample.position + shift;
      int u = 0;
      int v = 0;
      const double measured = depth_at(position, u, v);
      if (measured == 0) {
        sum += 1;
        continue;
      }
      sum += 0.5 * std::min(1.0, std::abs(measured - position.z()) / config_.depth_tolerance);
      sum += 0.5 * std::min(1.0, std::abs(view_.texture.at(u, v) - sample.brightness) / config_.brightness_tolerance);
    }
    return sum / static_cast<double>(samples.size());
  }

  /// A shift by pixels, with the depth at which most of the points then lie on something.
  Eigen::Vector3d shift_for(std::span<const Sample> samples, double du, double dv, double mean_depth) const {
    const auto shift = [&](double depth_change) {
      const double z = mean_depth + depth_change;
      return Eigen::Vector3d(du * z / view_.intrinsics.fx, dv * z / view_.intrinsics.fy, depth_change);
    };
    std::vector<double> changes;
    const Eigen::Vector3d lateral = shift(0);
    for (const Sample& sample : samples) {
      int u = 0;
      int v = 0;
      const double measured = depth_at(sample.position + lateral, u, v);
      if (measured > 0) changes.push_back(measured - sample.position.z());
    }
    return changes.empty() ? lateral : shift(median(changes));
  }

private:
  const LayerView& view_;
  const PoseSearchConfig& config_;
};

struct Candidate {
  Eigen::Vector3d shift;
  double cost;
};

// The best shifts that are not beside a better one.
std::vector<Candidate> best_of(std::vector<Candidate> all, std::size_t max_count, double apart) {
  std::stable_sort(all.begin(), all.end(), [](const Candidate& a, const Candidate& b) { return a.cost < b.cost; });
  std::vector<Candidate> kept;
  for (const Candidate& candidate : all) {
    if (kept.size() >= max_count) break;
    const bool is_near = std::any_of(kept.begin(), kept.end(), [&](const Candidate& other) {
      return (other.shift - candidate.shift).norm() < apart;
    });
    if (!is_near) kept.push_back(candidate);
  }
  return kept;
}

} // namespace

double alignment_cost(const LayerModel& model, std::span<const PointTexture> textures, const LayerView& view,
                      const motion::NodeStates& states, const PoseSearchConfig& config) {
  return ShiftCost(view, config)
      .cost(samples_of(model, textures, states, model.points.size()), Eigen::Vector3d::Zero());
}

PoseSearchResult search_pose(const LayerModel& model, std::span<const PointTexture> textures, const LayerView& view,
                             const motion::NodeStates& start, const PoseSearchConfig& config) {
  PoseSearchResult best{start, 1};
  const std::vector<Sample> samples = samples_of(model, textures, start, config.max_points);
  if (samples.empty() || view.empty()) return best;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Sample& sample : samples) mean += sample.position / static_cast<double>(samples.size());
  if (!(mean.z() > 0.05)) return best;
  const Eigen::Vector2d centre = view.intrinsics.project(mean);
  const ShiftCost shift_cost(view, config);
  // The model's centre goes to every place of the view.
  const int step = std::max(1, std::max(view.intrinsics.width, view.intrinsics.height) / std::max(1, config.shifts));
  const int columns = view.intrinsics.width / step + 1;
  const int rows = view.intrinsics.height / step + 1;
  std::vector<Candidate> all(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  parallel_for(static_cast<std::size_t>(rows), kRowsPerChunk, [&](const Chunk& chunk) {
    for (std::size_t row = chunk.begin; row < chunk.end; ++row) {
      for (int column = 0; column < columns; ++column) {
        const double du = step * column - centre.x();
        const double dv = step * static_cast<double>(row) - centre.y();
        const Eigen::Vector3d shift = shift_cost.shift_for(samples, du, dv, mean.z());
        all[row * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column)] = {
            shift, shift_cost.cost(samples, shift)};
      }
    }
  });
  const double apart = 3 * step * mean.z() / view.intrinsics.fx;
  for (const Candidate& candidate : best_of(std::move(all), config.candidates, apart)) {
    motion::NodeStates states = moved(start, SE3(Eigen::Translation3d(candidate.shift)));
    states = align_rigidly(model, textures, view, states, 2, 0.10, 6);
    states = align_rigidly(model, textures, view, states, 1, 0.06, 6);
    const double cost = alignment_cost(model, textures, view, states, config);
    if (cost < best.cost) best = {std::move(states), cost};
  }
  return best;
}

} // namespace kinora::tracking
