#include "ingest/segmentation/background_map.h"
#include "ingest/depth/view_reprojection.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/parallel.h"
#include "ingest/segmentation/free_space_readings.h"

namespace kinora::ingest {
namespace {

constexpr double kNewKeyView = 0.25; ///< radians, or metres over the distance of what is seen, between two places
constexpr double kDistance = 2;      ///< metres: the distance of what is seen, in general
constexpr double kWidest = 1.7;      ///< tangent of the largest angle that a place looks at
constexpr int kSlack = 2;            ///< pixels that places of the camera may be off
constexpr std::size_t kMaxNear = 3;  ///< places that are asked
constexpr std::size_t kRowsPerChunk = 16;

double view_change(const SE3& a, const SE3& b) {
  const SE3 motion = a.inverse() * b;
  return rotation_angle(motion) + motion.translation().norm() / kDistance;
}

/// A camera at `key_view` that sees all that the views show which belong to it; with the same pixels as theirs.
Intrinsics canvas(const SE3& key_view, std::span<const ReducedView> samples, std::span<const SE3> key_views) {
  const Intrinsics& k = samples.front().intrinsics;
  Eigen::AlignedBox2d box;
  for (const ReducedView& sample : samples) {
    const auto nearest = std::min_element(key_views.begin(), key_views.end(), [&](const SE3& a, const SE3& b) {
      return view_change(a, sample.camera_to_world) < view_change(b, sample.camera_to_world);
    });
    if (nearest->matrix() != key_view.matrix()) continue;
    const Eigen::Matrix3d to_key_view = (key_view.inverse() * sample.camera_to_world).linear();
    for (const double u : {0.0, k.width - 1.0}) {
      for (const double v : {0.0, k.height - 1.0}) {
        const Eigen::Vector3d ray = to_key_view * k.unproject(u, v, 1);
        if (ray.z() > 0) box.extend(k.project(ray).array().min(1e6).max(-1e6).matrix());
      }
    }
  }
  const auto limits = [](double low, double high, double focal, double centre) {
    return std::pair{std::max(static_cast<int>(std::floor(low + 1e-6)), static_cast<int>(centre - kWidest * focal)),
                     std::min(static_cast<int>(std::ceil(high - 1e-6)), static_cast<int>(centre + kWidest * focal))};
  };
  const auto [left, right] = limits(box.min().x(), box.max().x(), k.fx, k.cx);
  const auto [top, bottom] = limits(box.min().y(), box.max().y(), k.fy, k.cy);
  return {right - left + 1, bottom - top + 1, k.fx, k.fy, k.cx - left, k.cy - top};
}

/// The pixel of a model that a point in its camera's space falls into; one beside the border is the border's.
std::optional<std::pair<int, int>> pixel_of(const BackgroundModel& model, const Eigen::Vector3d& point) {
  if (!(point.z() > 0)) return std::nullopt;
  const Eigen::Vector2d pixel = model.intrinsics().project(point);
  const int width = model.intrinsics().width;
  const int height = model.intrinsics().height;
  if (!(pixel.x() > -1 && pixel.y() > -1 && pixel.x() < width && pixel.y() < height)) return std::nullopt;
  return std::pair{std::clamp(nearest_pixel(pixel.x()), 0, width - 1),
                   std::clamp(nearest_pixel(pixel.y()), 0, height - 1)};
}

} // namespace

BackgroundMap::BackgroundMap(std::span<const ReducedView> samples) {
  std::vector<SE3> key_views;
  for (const ReducedView& sample : samples) {
    const bool known = std::any_of(key_views.begin(), key_views.end(), [&](const SE3& key_view) {
      return view_change(key_view, sample.camera_to_world) < kNewKeyView;
    });
    if (!known) key_views.push_back(sample.camera_to_world);
  }
  const bool moves = std::any_of(samples.begin(), samples.end(), [&](const ReducedView& sample) {
    return sample.camera_to_world.matrix() != samples.front().camera_to_world.matrix();
  });
  for (const SE3& key_view : key_views) {
    const Camera camera{canvas(key_view, samples, key_views), key_view};
    std::vector<ReducedView> seen;
    seen.reserve(samples.size());
    for (const ReducedView& sample : samples) seen.push_back(reproject(camera, sample));
    drop_oblique_readings(samples, seen);
    key_views_.push_back({key_view, BackgroundModel(seen, moves ? kSlack : 0)});
  }
}

double BackgroundMap::static_share() const {
  double sum = 0;
  for (const KeyView& key_view : key_views_) sum += key_view.model.static_share();
  return sum / static_cast<double>(key_views_.size());
}

LocalBackground::LocalBackground(const BackgroundMap& map, const Intrinsics& intrinsics, const SE3& camera_to_world)
    : intrinsics_(intrinsics) {
  std::vector<std::pair<double, const BackgroundMap::KeyView*>> order;
  for (const BackgroundMap::KeyView& key_view : map.key_views_)
    order.emplace_back(view_change(key_view.camera_to_world, camera_to_world), &key_view);
  std::stable_sort(order.begin(), order.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  order.resize(std::min(order.size(), kMaxNear));
  for (const auto& [change, key_view] : order) {
    const SE3 from_camera = key_view->camera_to_world.inverse() * camera_to_world;
    near_.push_back({&key_view->model, from_camera, from_camera.inverse()});
  }
}

Ground LocalBackground::ground_of(const Eigen::Vector3d& point) const {
  if (!(point.z() > 0)) return Ground::kUnmeasured;
  bool moved = false;
  for (const Near& near : near_) {
    const Eigen::Vector3d seen = near.from_camera * point;
    const auto pixel = pixel_of(*near.model, seen);
    if (!pixel) continue;
    if (moved) {
      if (near.model->is_on_background(pixel->first, pixel->second, seen)) return Ground::kBackground;
      continue;
    }
    const Ground ground = near.model->ground_of(pixel->first, pixel->second, seen);
    if (ground == Ground::kBackground) return ground;
    moved = ground == Ground::kForeground;
  }
  return moved ? Ground::kForeground : Ground::kBackground;
}

bool LocalBackground::is_clear_foreground(const Eigen::Vector3d& point) const {
  return std::all_of(near_.begin(), near_.end(), [&](const Near& near) {
    const Eigen::Vector3d seen = near.from_camera * point;
    const auto pixel = pixel_of(*near.model, seen);
    return !pixel || near.model->is_clear_foreground(pixel->first, pixel->second, seen);
  });
}

Image<Ground> LocalBackground::ground_of(const ReducedView& view) const {
  Image<Ground> ground(view.depth.width(), view.depth.height());
  parallel_for(static_cast<std::size_t>(ground.height()), kRowsPerChunk, [&](const Chunk& rows) {
    for (int v = static_cast<int>(rows.begin); v < static_cast<int>(rows.end); ++v)
      for (int u = 0; u < ground.width(); ++u)
        ground.at(u, v) = ground_of(view.intrinsics.unproject(u, v, view.depth.at(u, v)));
  });
  return ground;
}

bool LocalBackground::ever_measured(const Eigen::Vector3d& point) const {
  return std::any_of(near_.begin(), near_.end(), [&](const Near& near) {
    const auto pixel = pixel_of(*near.model, near.from_camera * point);
    return pixel && near.model->measured().at(pixel->first, pixel->second) != 0;
  });
}

std::optional<int> LocalBackground::color_difference(int u, int v, const std::uint8_t* color) const {
  for (const Near& near : near_) {
    // As if infinitely far; then at the background's depth there.
    const Eigen::Vector3d ray = intrinsics_.unproject(u, v, 1);
    auto pixel = pixel_of(*near.model, near.from_camera.linear() * ray);
    if (!pixel) continue;
    const double behind = near.model->depth().at(pixel->first, pixel->second);
    if (behind > 0 && std::isfinite(behind)) {
      const Eigen::Vector3d model_point = near.model->intrinsics().unproject(pixel->first, pixel->second, behind);
      pixel = pixel_of(*near.model, near.from_camera * ((near.to_camera * model_point).z() * ray));
      if (!pixel) continue;
    }
    if (const auto found = near.model->color_difference(pixel->first, pixel->second, color)) return found;
  }
  return std::nullopt;
}

} // namespace kinora::ingest
