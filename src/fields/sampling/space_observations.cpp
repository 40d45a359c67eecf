#include "fields/sampling/space_observations.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <memory>
#include <span>

#include "core/parallel.h"
#include "core/random.h"
#include "fields/sampling/parallel_append.h"
#include "fields/sampling/surface_band.h"
#include "motion/bulk_warp.h"

namespace kinora::fields {
namespace {

using motion::BulkWarp;

constexpr std::size_t kMaxPoints = 2'000'000; // of all frames together

std::array<float, 3> to_array(const Eigen::Vector3f& v) { return {v.x(), v.y(), v.z()}; }
Eigen::Vector3f to_vector(const std::array<float, 3>& v) { return Eigen::Vector3f(v.data()); }

/// Middles of the occupied cells, relative to a point of canonical space, metres.
std::vector<std::array<float, 3>> occupied_centres(const Occupancy& occupancy, const FieldBox& box,
                                                   const Eigen::Vector3d& origin) {
  std::vector<std::array<float, 3>> points;
  points.reserve(occupancy.count());
  const auto r = static_cast<std::size_t>(occupancy.resolution());
  const auto side = static_cast<float>(box.side / occupancy.resolution());
  const Eigen::Vector3f first = (box.origin - origin).cast<float>() + Eigen::Vector3f::Constant(side / 2);
  for (std::size_t w = 0; w < occupancy.words().size(); ++w) {
    for (std::uint64_t bits = occupancy.words()[w]; bits != 0; bits &= bits - 1) {
      const std::size_t cell = w * 64 + static_cast<std::size_t>(std::countr_zero(bits));
      const std::size_t x = cell % r;
      const std::size_t y = cell / r % r;
      const std::size_t z = cell / (r * r);
      points.push_back({first.x() + side * static_cast<float>(x), first.y() + side * static_cast<float>(y),
                        first.z() + side * static_cast<float>(z)});
    }
  }
  return points;
}

/// A point of an occupied cell in one frame.
struct WarpedCellPoint {
  std::array<float, 3> canonical; ///< relative to the origin of canonical points
  BulkWarp::WarpedPoint world;
  std::uint16_t u, v; ///< the pixel that looks through it
  float depth;        ///< 0: the camera does not see it
};

/// A random point of each occupied cell, or of every so many-th, carried into a frame.
class WarpedCells {
public:
  WarpedCells(const motion::Motion& motion, const Occupancy& occupancy, const FieldBox& box, std::size_t frames)
      : motion_(motion), box_(box), cell_(static_cast<float>(box.side / occupancy.resolution())) {
    if (motion.graph() != nullptr) table_ = std::make_shared<const motion::InfluenceTable>(motion.graph());
    canonical_origin_ = table_ != nullptr ? table_->origin() : box.origin;
    cells_ = occupied_centres(occupancy, box, canonical_origin_);
    stride_ = 1 + cells_.size() * frames / kMaxPoints;
  }

  float cell() const { return cell_; }
  const std::vector<WarpedCellPoint>& points() const { return points_; }

  void warp_to(const StoredFrame& frame) {
    frame_ = &frame;
    if (table_ != nullptr) {
      const BulkWarp warp(table_, motion_.warp(frame.frame));
      warp_to(warp.world_origin(), [&](std::span<const std::array<float, 3>> canonical, BulkWarp::WarpedPoint* world) {
        warp.to_world(canonical, world);
      });
      return;
    }
    const SE3 pose = motion_.canonical_to_world(frame.frame);
    const Eigen::Matrix3f rotation = pose.linear().cast<float>();
    const Eigen::Quaternionf q(rotation);
    warp_to(pose * canonical_origin_,
            [&](std::span<const std::array<float, 3>> canonical, BulkWarp::WarpedPoint* world) {
              for (std::size_t i = 0; i < canonical.size(); ++i) {
                world[i] = {to_array(rotation * to_vector(canonical[i])), {q.x(), q.y(), q.z(), q.w()}};
              }
            });
  }

  /// The ray of a pixel that looks through the place, as it passes there.
  FieldRay ray(const WarpedCellPoint& point, const StoredPixel& pixel) const {
    const RowRay in_camera = frame_->ray(pixel);
    const Eigen::Vector3f camera = camera_ + camera_rotation_ * in_camera.origin.cast<float>();
    const Eigen::Vector3f direction = camera_rotation_ * in_camera.direction.cast<float>();
    const Eigen::Quaternionf back = Eigen::Quaternionf(point.world.rotation.data()).conjugate();
    const auto per_metre = static_cast<float>(1 / box_.side);
    const Eigen::Vector3f origin =
        canonical_from_box_ + to_vector(point.canonical) + back * (camera - to_vector(point.world.point));
    return {to_array(per_metre * origin), to_array(per_metre * (back * direction)), direction.norm()};
  }

private:
  template <class ToWorld> void warp_to(const Eigen::Vector3d& world_origin, const ToWorld& to_world) {
    constexpr std::size_t kChunk = 2048;
    camera_ = (frame_->camera.camera_to_world.translation() - world_origin).cast<float>();
    camera_rotation_ = frame_->camera.camera_to_world.linear().cast<float>();
    canonical_from_box_ = (canonical_origin_ - box_.origin).cast<float>();
    const std::size_t first = static_cast<std::size_t>(frame_->frame) % stride_;
    points_.resize(cells_.size() > first ? (cells_.size() - first - 1) / stride_ + 1 : 0);
    parallel_for(points_.size(), kChunk, [&](const Chunk& chunk) {
      Random random(0x5BACE + static_cast<std::uint64_t>(frame_->frame), chunk.index);
      std::vector<std::array<float, 3>> canonical;
      canonical.reserve(kChunk);
      for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
        canonical.push_back(cells_[first + i * stride_]);
        for (float& x : canonical.back()) x += cell_ * (random.uniform() - 0.5F);
      }
      std::vector<BulkWarp::WarpedPoint> world(canonical.size());
      to_world(canonical, world.data());
      for (std::size_t k = 0; k < canonical.size(); ++k) {
        WarpedCellPoint& point = points_[chunk.begin + k];
        point = {canonical[k], world[k], 0, 0, 0};
        project(point);
      }
    });
  }

  /// From the camera at the middle of its rows to where it is when it reads the row that shows the point.
  Eigen::Vector3f in_row(const Eigen::Vector3f& at_middle) const {
    if (frame_->readout.isZero(0)) return at_middle;
    const Intrinsics& k = frame_->camera.intrinsics;
    const Eigen::Matrix<float, 6, 1> readout = frame_->readout.cast<float>();
    const Eigen::Vector3f motion = readout.head<3>() + readout.tail<3>().cross(at_middle);
    const double v = k.fy * at_middle.y() / at_middle.z() + k.cy;
    return at_middle - static_cast<float>(std::clamp(row_time(v, k.height), -0.5, 0.5)) * motion;
  }

  void project(WarpedCellPoint& point) const {
    const Intrinsics& k = frame_->camera.intrinsics;
    const Eigen::Vector3f at_middle = camera_rotation_.transpose() * (to_vector(point.world.point) - camera_);
    if (!(at_middle.z() > 0)) return;
    const Eigen::Vector3f in_camera = in_row(at_middle);
    if (!(in_camera.z() > 0)) return;
    const float u = static_cast<float>(k.fx) * in_camera.x() / in_camera.z() + static_cast<float>(k.cx) + 0.5F;
    const float v = static_cast<float>(k.fy) * in_camera.y() / in_camera.z() + static_cast<float>(k.cy) + 0.5F;
    if (!(u >= 0 && u < static_cast<float>(k.width) && v >= 0 && v < static_cast<float>(k.height))) return;
    point.u = static_cast<std::uint16_t>(u);
    point.v = static_cast<std::uint16_t>(v);
    point.depth = in_camera.z();
  }

  const motion::Motion& motion_;
  FieldBox box_;
  float cell_; ///< metres
  std::shared_ptr<const motion::InfluenceTable> table_;
  Eigen::Vector3d canonical_origin_;
  std::vector<std::array<float, 3>> cells_; ///< their middles, relative to the origin of canonical points
  std::size_t stride_;
  std::vector<WarpedCellPoint> points_;
  const StoredFrame* frame_ = nullptr;
  Eigen::Vector3f camera_; ///< relative to the origin of world points
  Eigen::Matrix3f camera_rotation_;
  Eigen::Vector3f canonical_from_box_; ///< origin of canonical points from the box's corner
};

/// For blocks of pixels some cells wide, the nearest place that they see.
class NearestPointMap {
public:
  explicit NearestPointMap(const WarpedCells& space, const Intrinsics& camera) : points_(space.points()) {
    float nearest = kFarthest;
    for (const WarpedCellPoint& point : points_) {
      if (point.depth > 0) nearest = std::min(nearest, point.depth);
    }
    const double side = std::ceil(2 * static_cast<double>(space.cell()) * camera.fx / static_cast<double>(nearest));
    block_ = static_cast<std::size_t>(std::clamp(side, 1.0, static_cast<double>(std::max(camera.width, 1))));
    columns_ = static_cast<std::size_t>(camera.width) / block_ + 1;
    nearest_.assign(columns_ * (static_cast<std::size_t>(camera.height) / block_ + 1), nullptr);
    for (const WarpedCellPoint& point : points_) {
      const WarpedCellPoint*& first = nearest_[block_of(point.u, point.v)];
      if (point.depth > 0 && (first == nullptr || point.depth < first->depth)) first = &point;
    }
  }

  /// nullptr if none is seen.
  const WarpedCellPoint* at(const StoredPixel& pixel) const { return nearest_[block_of(pixel.u, pixel.v)]; }

private:
  std::size_t block_of(std::size_t u, std::size_t v) const { return v / block_ * columns_ + u / block_; }

  const std::vector<WarpedCellPoint>& points_;
  std::size_t block_ = 1; ///< pixels
  std::size_t columns_ = 0;
  std::vector<const WarpedCellPoint*> nearest_;
};

/// What a frame's pixels can say of a layer.
struct FrameObservations {
  struct Observation {
    std::uint32_t pixel;    ///< into PixelStore::pixels()
    float free_space_until; ///< metres; 0: it says nothing
  };
  std::vector<Observation> at; ///< for each pixel of the image
  std::vector<std::uint32_t> without_depth;
  bool any_free_space = false;

  void gather(const LayerObservations& layer, const StoredFrame& frame, const FieldConfig& config, SensorNoise noise) {
    const bool deforms = layer.deforms();
    const auto width = static_cast<std::size_t>(frame.camera.intrinsics.width);
    at.assign(width * static_cast<std::size_t>(frame.camera.intrinsics.height), {});
    without_depth.clear();
    any_free_space = false;
    for (std::size_t i = frame.begin; i < frame.end; ++i) {
      const StoredPixel& pixel = layer.pixels.pixels()[i];
      const auto number = static_cast<std::uint32_t>(i);
      float free_until = 0;
      if (!layer.is_foreground(pixel)) {
        free_until = free_space_until(pixel, noise);
      } else if (deforms && pixel.depth.is_measured()) {
        free_until = pixel.depth.metres() - surface_band(config, pixel.depth.metres(), noise);
      } else if (layer.label != 0 && !pixel.depth.is_known()) {
        without_depth.push_back(number);
      }
      at[pixel.v * width + pixel.u] = {number, free_until};
      any_free_space = any_free_space || free_until > 0;
    }
  }
};

} // namespace

SpaceObservations observe_occupied_space(const LayerObservations& layer, const FieldConfig& config,
                                         const Occupancy& occupancy, float near_depth, SensorNoise noise) {
  constexpr float kSegmentCells = 2; // so far a ray is taken as straight
  const PixelStore& pixels = layer.pixels;
  ParallelAppend<UnmeasuredRaySegment> unmeasured;
  ParallelAppend<RaySegment> free_space;
  WarpedCells space(layer.motion, occupancy, config.box, pixels.frames().size());
  FrameObservations observations;
  for (const StoredFrame& frame : pixels.frames()) {
    if (layer.is_lost(frame)) continue;
    observations.gather(layer, frame, config, noise);
    if (!observations.any_free_space && observations.without_depth.empty()) continue;
    space.warp_to(frame);
    const auto width = static_cast<std::size_t>(frame.camera.intrinsics.width);
    const auto ray_at = [&](const WarpedCellPoint& point, std::uint32_t pixel) {
      return space.ray(point, pixels.pixels()[pixel]);
    };
    free_space.append(space.points().size(), [&](const Chunk& chunk, std::vector<RaySegment>& part) {
      for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
        const WarpedCellPoint& point = space.points()[i];
        if (point.depth < near_depth) continue;
        const FrameObservations::Observation& observation = observations.at[point.v * width + point.u];
        if (!(point.depth < observation.free_space_until)) continue;
        const FieldRay ray = ray_at(point, observation.pixel);
        const float half = 0.5F * kSegmentCells * space.cell() / ray.metres_per_depth;
        part.push_back(
            {observation.pixel,
             ray,
             {std::max(point.depth - half, near_depth), std::min(point.depth + half, observation.free_space_until)}});
      }
    });
    if (observations.without_depth.empty()) continue;
    const NearestPointMap first(space, frame.camera.intrinsics);
    unmeasured.append(
        observations.without_depth.size(), [&](const Chunk& chunk, std::vector<UnmeasuredRaySegment>& part) {
          for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
            const std::uint32_t pixel = observations.without_depth[i];
            const WarpedCellPoint* point = first.at(pixels.pixels()[pixel]);
            if (point == nullptr) continue;
            const FieldRay ray = ray_at(*point, pixel);
            const float side = space.cell() / ray.metres_per_depth;
            const float begin = std::max(point->depth - side / 2, near_depth);
            part.push_back({{pixel, ray, {begin, begin + kSegmentCells * side}}, packed(point->world.rotation)});
          }
        });
  }
  return {unmeasured.joined(), free_space.joined()};
}

} // namespace kinora::fields
