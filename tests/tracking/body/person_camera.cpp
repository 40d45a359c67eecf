#include "tracking/body/person_camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/parallel.h"
#include "core/random.h"
#include "ingest/depth/depth_cleaning.h"
#include "tracking/scenes/faulty_sensor.h"

namespace kinora::tracking::testing {
namespace {

using Vec = Eigen::Vector3d;

constexpr double kBlurSteps = 5;

Intrinsics intrinsics_of(const PersonCamera& camera) {
  return {camera.width, camera.height, camera.focal, camera.focal, camera.width / 2.0, camera.height / 2.0};
}

/// Linear light (three channels) and depth without faults; 0: nobody.
struct Picture {
  Image<float> light;
  DepthImage depth;
};

Picture draw(const DressedPerson& person, const Intrinsics& intrinsics) {
  const Vec light = Vec(-0.4, -0.8, -0.5).normalized();
  Picture picture{Image<float>(intrinsics.width, intrinsics.height, 3, 0.18F),
                  DepthImage(intrinsics.width, intrinsics.height)};
  parallel_for(static_cast<std::size_t>(intrinsics.height), 4, [&](const Chunk& chunk) {
    for (int v = static_cast<int>(chunk.begin); v < static_cast<int>(chunk.end); ++v) {
      for (int u = 0; u < intrinsics.width; ++u) {
        const auto hit = person.trace(intrinsics.unproject(u, v, 1));
        if (!hit) continue;
        const Vec colour = (0.45 + 0.55 * std::max(0.0, hit->normal.dot(light))) * DressedPerson::colour_of(hit->point);
        std::copy_n(colour.cast<float>().eval().data(), 3, picture.light.pixel(u, v));
        picture.depth.at(u, v) = static_cast<float>(hit->z);
      }
    }
  });
  return picture;
}

// Points spread as the body's samples are, and over the skirt.
std::vector<CoatPoint> material_points(bool has_skirt, std::size_t count) {
  constexpr int kSkirtRows = 6;
  constexpr int kSkirtColumns = 14;
  std::vector<CoatPoint> points;
  const auto samples = body_samples();
  const std::size_t stride = std::max<std::size_t>(1, samples.size() / count);
  for (std::size_t i = 0; i < samples.size(); i += stride) points.push_back({samples[i].part, samples[i].point});
  for (int i = 0; has_skirt && i < kSkirtRows * kSkirtColumns; ++i) {
    const double angle = 2 * std::numbers::pi * (i % kSkirtColumns) / kSkirtColumns - std::numbers::pi;
    const int row = i / kSkirtColumns;
    const double along = (row + 0.5) / kSkirtRows;
    points.push_back({kBodyParts, {along, Vec(angle, 0, 0)}});
  }
  return points;
}

} // namespace

ingest::Frame see_person(const PersonScene& scene, int frame, const PersonCamera& camera) {
  ingest::Frame result;
  result.index = frame;
  result.time = frame / kSceneRate;
  result.camera.intrinsics = intrinsics_of(camera);
  Picture picture = draw(scene.at(frame), result.camera.intrinsics);
  if (scene.exposure > 0) {
    std::fill(picture.light.values().begin(), picture.light.values().end(), 0.0F);
    for (double i = 0; i < kBlurSteps; ++i) {
      const double moment = frame + scene.exposure * ((i + 0.5) / kBlurSteps - 0.5);
      const Picture step = draw(scene.at(moment), result.camera.intrinsics);
      for (std::size_t k = 0; k < step.light.values().size(); ++k) {
        picture.light.values()[k] += step.light.values()[k] / static_cast<float>(kBlurSteps);
      }
    }
  }
  Random random(camera.seed, static_cast<std::uint64_t>(frame));
  result.color = exposed(picture.light, random);
  result.labels = LabelImage(camera.width, camera.height);
  for (std::size_t k = 0; k < picture.depth.values().size(); ++k) {
    result.labels.values()[k] = picture.depth.values()[k] > 0 ? 1 : 0;
  }
  result.depth = measured(picture.depth, random);
  result.clean_depth = ingest::clean_depth(result.depth, result.camera.intrinsics);
  return result;
}

evaluate::GroundTruthTracks track_person(const PersonScene& scene, std::size_t count, const PersonCamera& camera,
                                         std::span<const std::size_t> parts) {
  constexpr double kTolerance = 0.004; // metres between a point and what its ray meets
  const Intrinsics intrinsics = intrinsics_of(camera);
  const std::vector<CoatPoint> points = material_points(scene.has_skirt, count);
  evaluate::GroundTruthTracks tracks;
  for (int frame = 0; frame < scene.frames; ++frame) {
    const DressedPerson person = scene.at(frame);
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (!parts.empty() && std::find(parts.begin(), parts.end(), points[i].part) == parts.end()) continue;
      const Vec position = person.coat_position(points[i]);
      const Eigen::Vector2d pixel = intrinsics.project(position);
      const bool inside =
          pixel.x() > 0 && pixel.y() > 0 && pixel.x() < camera.width - 1 && pixel.y() < camera.height - 1;
      const auto hit = person.trace(position / position.z());
      const bool visible = inside && hit && std::abs(hit->z - position.z()) < kTolerance;
      tracks[static_cast<int>(i)][frame] = {position, visible};
    }
  }
  return tracks;
}

} // namespace kinora::tracking::testing
