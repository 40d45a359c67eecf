#include "tracking/deforming/layer_search.h"

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
struct Probe {
  Eigen::Vector3d place;
  double brightness;
};

std::vector<Probe> probes_of(const LayerModel& model, std::span<const PointTexture> textures,
                             const motion::NodeStates& states, std::size_t most) {
  std::vector<Probe> probes;
  const std::size_t stride = std::max<std::size_t>(1, model.points.size() / std::max<std::size_t>(1, most));
  for (std::size_t p = 0; p < model.points.size(); p += stride) {
    const motion::SkinnedPoint& point = model.points[p];
    probes.push_back({motion::blend_motion(states, point.influence()).apply(point.position.cast<double>()),
                      static_cast<double>(textures[p].fused)});
  }
  return probes;
}

class Judge {
public:
  Judge(const ObjectView& view, const LayerSearchConfig& config) : view_(view), config_(config) {}

  /// Depth measured behind a place, or 0.
  double depth_at(const Eigen::Vector3d& place, int& u, int& v) const {
    if (!(place.z() > kNearestDepth)) return 0;
    const Eigen::Vector2d pixel = view_.intrinsics.project(place);
    if (!is_in_picture(pixel.x(), pixel.y(), view_.intrinsics)) return 0;
    u = static_cast<int>(std::lround(pixel.x()));
    v = static_cast<int>(std::lround(pixel.y()));
    return view_.planes.weights.at(u, v) > 0 ? view_.point(u, v).z() : 0.0;
  }

  double cost(std::span<const Probe> probes, const Eigen::Vector3d& shift) const {
    if (probes.empty()) return 1;
    double sum = 0;
    for (const Probe& probe : probes) {
      const Eigen::Vector3d place = probe.place + shift;
      int u = 0;
      int v = 0;
      const double measured = depth_at(place, u, v);
      if (measured == 0) {
        sum += 1;
        continue;
      }
      sum += 0.5 * std::min(1.0, std::abs(measured - place.z()) / config_.depth_tolerance);
      sum += 0.5 * std::min(1.0, std::abs(view_.texture.at(u, v) - probe.brightness) / config_.brightness_tolerance);
    }
    return sum / static_cast<double>(probes.size());
  }

  /// A shift by pixels, with the depth at which most of the points then lie on something.
  Eigen::Vector3d shift_for(std::span<const Probe> probes, double du, double dv, double mean_depth) const {
    const auto shift = [&](double depth_change) {
      const double z = mean_depth + depth_change;
      return Eigen::Vector3d(du * z / view_.intrinsics.fx, dv * z / view_.intrinsics.fy, depth_change);
    };
    std::vector<double> changes;
    const Eigen::Vector3d sideways = shift(0);
    for (const Probe& probe : probes) {
      int u = 0;
      int v = 0;
      const double measured = depth_at(probe.place + sideways, u, v);
      if (measured > 0) changes.push_back(measured - probe.place.z());
    }
    return changes.empty() ? sideways : shift(median(changes));
  }

private:
  const ObjectView& view_;
  const LayerSearchConfig& config_;
};

struct Candidate {
  Eigen::Vector3d shift;
  double cost;
};

// The best shifts that are not beside a better one.
std::vector<Candidate> best_of(std::vector<Candidate> all, std::size_t most, double apart) {
  std::stable_sort(all.begin(), all.end(), [](const Candidate& a, const Candidate& b) { return a.cost < b.cost; });
  std::vector<Candidate> kept;
  for (const Candidate& candidate : all) {
    if (kept.size() >= most) break;
    const bool beside = std::any_of(kept.begin(), kept.end(), [&](const Candidate& other) {
      return (other.shift - candidate.shift).norm() < apart;
    });
    if (!beside) kept.push_back(candidate);
  }
  return kept;
}

} // namespace

double contradiction(const LayerModel& model, std::span<const PointTexture> textures, const ObjectView& view,
                     const motion::NodeStates& states, const LayerSearchConfig& config) {
  return Judge(view, config).cost(probes_of(model, textures, states, model.points.size()), Eigen::Vector3d::Zero());
}

LayerPlace search_layer(const LayerModel& model, std::span<const PointTexture> textures, const ObjectView& view,
                        const motion::NodeStates& start, const LayerSearchConfig& config) {
  LayerPlace best{start, 1};
  const std::vector<Probe> probes = probes_of(model, textures, start, config.max_points);
  if (probes.empty() || view.empty()) return best;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Probe& probe : probes) mean += probe.place / static_cast<double>(probes.size());
  if (!(mean.z() > 0.05)) return best;
  const Eigen::Vector2d centre = view.intrinsics.project(mean);
  const Judge judge(view, config);
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
        const Eigen::Vector3d shift = judge.shift_for(probes, du, dv, mean.z());
        all[row * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column)] = {shift,
                                                                                           judge.cost(probes, shift)};
      }
    }
  });
  const double apart = 3 * step * mean.z() / view.intrinsics.fx;
  for (const Candidate& candidate : best_of(std::move(all), config.candidates, apart)) {
    motion::NodeStates states = moved(start, SE3(Eigen::Translation3d(candidate.shift)));
    states = align_rigidly(model, textures, view, states, 2, 0.10, 6);
    states = align_rigidly(model, textures, view, states, 1, 0.06, 6);
    const double cost = contradiction(model, textures, view, states, config);
    if (cost < best.cost) best = {std::move(states), cost};
  }
  return best;
}

} // namespace kinora::tracking
