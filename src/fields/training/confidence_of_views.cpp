#include "fields/training/confidence_of_views.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "fields/sampling/layer_points.h"

namespace kinora::fields {
namespace {

/// Looks at one block by the direction towards the camera: on a cube of 5³ places, of which those on its surface are
/// no more than 16° from any direction.
class Looks {
public:
  static constexpr int kSide = 5;
  static constexpr std::size_t kPlaces = kSide * kSide * kSide;

  void add(const Eigen::Vector3f& towards_camera, float looks) {
    const Eigen::Vector3f on_cube = towards_camera * (kMiddle / towards_camera.cwiseAbs().maxCoeff());
    const auto place = [&on_cube](int axis) { return static_cast<int>(std::lround(on_cube[axis])) + kMiddle; };
    const int number = (place(2) * kSide + place(1)) * kSide + place(0);
    looks_[static_cast<std::size_t>(number)] += looks;
  }

  /// What the looks are worth for a surface with a normal, whose places are ordered().
  struct Place {
    std::size_t number;
    float cosine;
  };
  float worth(const std::vector<Place>& places) const {
    float best = 0, looks = 0;
    for (const Place& place : places) {
      looks += looks_[place.number]; // from here or nearer to the normal
      best = std::max(best, place.cosine * looks / (looks + 1));
    }
    return best;
  }

  /// Places on the normal's side, the nearest first.
  static std::vector<Place> ordered(const Eigen::Vector3f& normal) {
    std::vector<Place> places;
    for (int i = 0; i < static_cast<int>(kPlaces); ++i) {
      const Eigen::Vector3i at(i % kSide - kMiddle, i / kSide % kSide - kMiddle, i / (kSide * kSide) - kMiddle);
      const float cosine = at.cast<float>().normalized().dot(normal);
      if (cosine > 0) places.push_back({static_cast<std::size_t>(i), cosine});
    }
    std::stable_sort(places.begin(), places.end(), [](const Place& a, const Place& b) { return a.cosine > b.cosine; });
    return places;
  }

private:
  static constexpr int kMiddle = kSide / 2;
  std::array<float, kPlaces> looks_{};
};

} // namespace

Confidence confidence_of_views(const LayerObservations& layer, const Field& field) {
  constexpr std::size_t kPoints = 100'000;
  Confidence confidence(field.occupancy);
  const FieldBox& box = field.config.box;
  const double block = box.side / confidence.blocks().resolution();
  std::vector<Looks> looks(confidence.levels().size());
  for (const LayerPoint& point : measured_points(layer, kPoints)) {
    const Eigen::Vector3f at = ((point.canonical - box.origin) / box.side).cast<float>();
    const Confidence::Near near = confidence.near({at.x(), at.y(), at.z()});
    const double faces = point.pixels * std::pow(point.footprint / block, 2);
    for (std::size_t i = 0; i < 8; ++i) {
      if (near.shares[i] > 0) {
        looks[near.blocks[i]].add(point.towards_camera.cast<float>(), near.shares[i] * static_cast<float>(faces));
      }
    }
  }
  std::array<std::vector<Looks::Place>, Confidence::kNormals> places;
  for (std::size_t n = 0; n < places.size(); ++n) places[n] = Looks::ordered(Confidence::normal(n));
  parallel_for(looks.size(), 1024, [&](const Chunk& chunk) {
    for (std::size_t b = chunk.begin; b < chunk.end; ++b) {
      for (std::size_t n = 0; n < places.size(); ++n) {
        const float level = Confidence::kMost * looks[b].worth(places[n]);
        confidence.levels()[b][n] = static_cast<std::uint8_t>(std::lround(level));
      }
    }
  });
  return confidence;
}

} // namespace kinora::fields
