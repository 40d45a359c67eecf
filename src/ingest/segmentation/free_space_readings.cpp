#include "ingest/segmentation/free_space_readings.h"

#include <algorithm>
#include <vector>

#include "core/parallel.h"

namespace kinora::ingest {
namespace {

constexpr std::size_t kRowsPerChunk = 8;
constexpr std::size_t kMinReadings = 2; ///< of a surface, to stand in front of another
constexpr float kUnmeasured = 0;

/// Medians of the surfaces that sorted depths belong to, the nearest first.
void surfaces_of(const std::vector<float>& sorted, std::vector<float>& surfaces) {
  surfaces.clear();
  for (std::size_t begin = 0, end = 0; begin < sorted.size(); begin = end) {
    for (end = begin + 1; end < sorted.size(); ++end)
      if (sorted[end] - sorted[end - 1] > same_surface_tolerance(sorted[end])) break;
    if (end - begin >= kMinReadings) surfaces.push_back(sorted[begin + (end - begin) / 2]);
  }
}

/// A sample, and how points get there from the camera elsewhere.
struct Sample {
  const ReducedView* view;
  SE3 from_camera;
};

/// Whether the sample looks through a point in the camera's space: it measured farther, or nothing if it shows nothing
/// behind either.
bool is_in_free_space(const Sample& sample, const Eigen::Vector3d& point, float reading) {
  const Eigen::Vector3d seen = sample.from_camera * point;
  if (!(seen.z() > 0)) return false;
  const Eigen::Vector2d pixel = sample.view->intrinsics.project(seen);
  if (!(pixel.cwiseAbs().maxCoeff() < 1e6)) return false;
  const int u = nearest_pixel(pixel.x());
  const int v = nearest_pixel(pixel.y());
  if (!sample.view->depth.contains(u, v)) return false;
  const double measured = sample.view->depth.at(u, v);
  if (measured == kUnmeasured) return reading == kUnmeasured;
  return violates_free_space(seen.z(), measured, kSameSurface);
}

} // namespace

void drop_oblique_readings(std::span<const ReducedView> samples, std::span<ReducedView> seen) {
  std::vector<Sample> others;
  for (std::size_t k = 0; k < samples.size(); ++k)
    others.push_back({&samples[k], samples[k].camera_to_world.inverse() * seen[k].camera_to_world});
  const Intrinsics& camera = seen.front().intrinsics;
  parallel_for(static_cast<std::size_t>(camera.height), kRowsPerChunk, [&](const Chunk& rows) {
    std::vector<float> readings, surfaces;
    for (int v = static_cast<int>(rows.begin); v < static_cast<int>(rows.end); ++v) {
      for (int u = 0; u < camera.width; ++u) {
        readings.clear();
        for (const ReducedView& view : seen)
          if (const float z = view.depth.at(u, v); z > 0) readings.push_back(z);
        std::sort(readings.begin(), readings.end());
        surfaces_of(readings, surfaces);
        if (surfaces.empty()) continue;
        for (std::size_t k = 0; k < seen.size(); ++k) {
          float& z = seen[k].depth.at(u, v);
          if (z == kUnseen) continue;
          for (const float nearer : surfaces) {
            if (z != kUnmeasured && nearer + same_surface_tolerance(nearer) >= z) break;
            if (is_in_free_space(others[k], camera.unproject(u, v, nearer), z)) continue;
            z = kUnseen;
            break;
          }
        }
      }
    }
  });
}

} // namespace kinora::ingest
