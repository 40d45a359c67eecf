#include "fields/training/view_confidence.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "fields/sampling/layer_points.h"

namespace kinora::fields {
namespace {

/// Looks at one block by the direction towards the camera: on a cube of 5³ places, of which those on its surface are
/// no more than 16° from any direction.
class ViewCounts {
public:
  static constexpr int kSide = 5;
  static constexpr std::size_t kDirections = kSide * kSide * kSide;

  void add(const Eigen::Vector3f& towards_camera, float views) {
    const Eigen::Vector3f on_cube = towards_camera * (kMiddle / towards_camera.cwiseAbs().maxCoeff());
    const auto cell = [&on_cube](int axis) { return static_cast<int>(std::lround(on_cube[axis])) + kMiddle; };
    const int number = (cell(2) * kSide + cell(1)) * kSide + cell(0);
    counts_[static_cast<std::size_t>(number)] += views;
  }

  /// What the looks are worth for a surface with a normal, whose places are ordered().
  struct Direction {
    std::size_t number;
    float cosine;
  };
  float confidence_towards(const std::vector<Direction>& directions) const {
    float best = 0, views = 0;
    for (const Direction& cell : directions) {
      views += counts_[cell.number]; // from here or nearer to the normal
      best = std::max(best, cell.cosine * views / (views + 1));
    }
    return best;
  }

  /// Places on the normal's side, the nearest first.
  static std::vector<Direction> ordered(const Eigen::Vector3f& normal) {
    std::vector<Direction> directions;
    for (int i = 0; i < static_cast<int>(kDirections); ++i) {
      const Eigen::Vector3i at(i % kSide - kMiddle, i / kSide % kSide - kMiddle, i / (kSide * kSide) - kMiddle);
      const float cosine = at.cast<float>().normalized().dot(normal);
      if (cosine > 0) directions.push_back({static_cast<std::size_t>(i), cosine});
    }
    std::stable_sort(directions.begin(), directions.end(),
                     [](const Direction& a, const Direction& b) { return a.cosine > b.cosine; });
    return directions;
  }

private:
  static constexpr int kMiddle = kSide / 2;
  std::array<float, kDirections> counts_{};
};

} // namespace

Confidence view_confidence(const LayerObservations& layer, const Field& field) {
  constexpr std::size_t kPoints = 100'000;
  Confidence confidence(field.occupancy);
  const FieldBox& box = field.config.box;
  const double block = box.side / confidence.blocks().resolution();
  std::vector<ViewCounts> views(confidence.levels().size());
  for (const LayerPoint& point : measured_points(layer, kPoints)) {
    const Eigen::Vector3f at = ((point.canonical - box.origin) / box.side).cast<float>();
    const Confidence::Near near = confidence.near({at.x(), at.y(), at.z()});
    const double faces = point.pixels * std::pow(point.footprint / block, 2);
    for (std::size_t i = 0; i < 8; ++i) {
      if (near.shares[i] > 0) {
        views[near.blocks[i]].add(point.towards_camera.cast<float>(), near.shares[i] * static_cast<float>(faces));
      }
    }
  }
  std::array<std::vector<ViewCounts::Direction>, Confidence::kNormals> directions;
  for (std::size_t n = 0; n < directions.size(); ++n) directions[n] = ViewCounts::ordered(Confidence::normal(n));
  parallel_for(views.size(), 1024, [&](const Chunk& chunk) {
    for (std::size_t b = chunk.begin; b < chunk.end; ++b) {
      for (std::size_t n = 0; n < directions.size(); ++n) {
        const float level = Confidence::kMax * views[b].confidence_towards(directions[n]);
        confidence.levels()[b][n] = static_cast<std::uint8_t>(std::lround(level));
      }
    }
  });
  return confidence;
}

} // namespace kinora::fields
