#include "fields/rendering/tile_marcher.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace kinora::fields {
namespace {

constexpr float kSameEntry = 2;         // lattice steps: an entry that near to a ray that is under way belongs to it
constexpr float kMinViewVector = 1e-3F; // metres: the way to a corner that near says nothing of where a ray goes
constexpr float kMinProgress = 0.01F; // lattice steps per sample: so little comes of corners turned against each other
constexpr float kProxyReach = 16; // lattice steps between a hull and its surface; farther, something stands before it

} // namespace

bool TileMarcher::enter(const PixelRay& pixel_ray, float until_depth, Ray& ray, float& begin) const {
  while (ray.next < entries_.count(ray.pixel)) {
    Entry entry = entries_.at(ray.pixel, ray.next);
    if (entry.depth < kMinViewVector) entry = {kMinViewVector, kInside};
    const ProjectedLayer::EntryPoint entry_point = view_->entry_point(entry, *bins_, pixel_ray.view_vector);
    if (ray.next++ > 0 && entry.depth < until_depth) {
      const Eigen::Vector3f before = ray.origin + (entry.depth - ray.entry_depth) / ray.depth_step * ray.direction;
      if ((entry_point.at - before).squaredNorm() < kSameEntry * kSameEntry) continue;
    }
    const float depth_step = view_->step() * pixel_ray.inverse_length;
    const float steps = entry.depth / depth_step; // from the camera
    const Eigen::Vector3f direction = entry_point.view_vector / steps;
    if (!(direction.squaredNorm() > kMinProgress * kMinProgress)) continue; // it would never leave
    ray.depth_step = depth_step;
    ray.direction = direction;
    ray.rotation = entry_point.rotation;
    ray.has_just_entered = true;
    // Samples lie on a ladder of depths that does not know of the hull, the first one behind the entry.
    const float rung = std::ceil(steps - 0.5F);
    ray.entry_depth = rung * ray.depth_step;
    ray.origin = entry_point.at + (rung - steps) * ray.direction;
    begin = ray.entry_depth < kNearDepth ? std::ceil((kNearDepth - ray.entry_depth) / ray.depth_step) : 0;
    return true;
  }
  return false;
}

void TileMarcher::begin(const PixelRay& pixel_ray, std::uint32_t pixel) {
  Ray ray{pixel, 0, true, true, 0, 1, Eigen::Vector3f::Zero(), Eigen::Vector3f::Zero(), kNoRotation};
  float begin = 0;
  if (!enter(pixel_ray, 0, ray, begin)) return;
  rays_.push_back(ray);
  begin_.push_back(begin);
}

void TileMarcher::march_anchors(const PixelRays& pixel_rays, Surfaces& surfaces) {
  anchored_ = true;
  cells_.clear();
  for (const std::uint32_t p : SmoothCells::anchors()) {
    if (entries_.count(p) > 0) begin(pixel_rays[p], p);
  }
  follow(pixel_rays, surfaces);
  cells_.find_smooth_cells(view_->step() / static_cast<float>(view_->layer().field.config.box.side));
}

// Whatever the layer has lies no nearer than a step before its first entry.
bool TileMarcher::enters_behind(const Surfaces& surfaces, std::uint32_t pixel) const {
  return transmittance_before(surfaces, pixel, entries_.at(pixel, 0).depth - view_->step()) <= kOpaque;
}

void TileMarcher::march(const PixelRays& pixel_rays, std::span<const std::uint32_t> pixels, bool only_visible,
                        Surfaces& surfaces) {
  const float reach = kProxyReach * view_->lattice_step();
  for (const std::uint32_t p : pixels) {
    if (entries_.count(p) == 0 || (only_visible && enters_behind(surfaces, p))) continue;
    if (!anchored_) march_anchors(pixel_rays, surfaces);
    if (SmoothCells::is_anchor(p)) continue;
    const auto surface = cells_.at(p);
    if (surface && surface->depth - entries_.at(p, 0).depth < reach) {
      surfaces.insert(p, *surface);
    } else {
      begin(pixel_rays[p], p);
    }
  }
  follow(pixel_rays, surfaces);
}

// All rays that have begun, to their ends.
void TileMarcher::follow(const PixelRays& pixel_rays, Surfaces& surfaces) {
  const ProjectedLayer& view = *view_;
  while (!rays_.empty()) {
    const std::size_t n = rays_.size();
    march_rays_.resize(n);
    runs_.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      const Ray& ray = rays_[i];
      march_rays_[i] = {{ray.origin.x(), ray.origin.y(), ray.origin.z()},
                        {ray.direction.x(), ray.direction.y(), ray.direction.z()}};
    }
    fields::march(view.layer().bricks, march_rays_.data(), begin_.data(), n, view.optical_length(), runs_.data(),
                  view.brick_index());
    points_.resize(n);
    positions_.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      const Ray& ray = rays_[i];
      positions_.set(i, ray.origin + runs_[i].mean * ray.direction);
      points_.set(i, (ray.entry_depth + runs_[i].mean * ray.depth_step) * pixel_rays[ray.pixel].view_vector);
    }
    if (view.deforms()) view.refine(n, points_, positions_);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < n; ++i) {
      Ray ray = rays_[i];
      const MarchRun& run = runs_[i];
      if (run.opacity > kMinShare) {
        const Surface surface{
            ray.entry_depth + run.median * ray.depth_step, run.opacity, layer_, view.to_box(positions_.at(i)),
            view.to_box(run.sigma * ray.direction),        ray.rotation};
        surfaces.insert(ray.pixel, surface);
        if (ray.is_unobstructed && run.reason == RunEnd::kOpaque && SmoothCells::is_anchor(ray.pixel)) {
          cells_.set(ray.pixel, surface);
        }
        ray.is_unobstructed = false;
      }
      if (run.reason == RunEnd::kOpaque) continue;
      float begin = run.end;
      const bool has_just_entered = std::exchange(ray.has_just_entered, false);
      if (has_just_entered && run.reason == RunEnd::kLeft && run.end == begin_[i]) {
        begin += 1; // a sample on the hull itself may lie outside by rounding; the next one tells
      } else if (run.reason == RunEnd::kLeft &&
                 !enter(pixel_rays[ray.pixel], ray.entry_depth + run.end * ray.depth_step, ray, begin)) {
        continue;
      }
      rays_[kept] = ray;
      begin_[kept++] = begin;
    }
    rays_.resize(kept);
    begin_.resize(kept);
  }
}

} // namespace kinora::fields
