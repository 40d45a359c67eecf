#include "fields/warped_pixels.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/parallel.h"
#include "fields/live_space.h"
#include "fields/surface_band.h"

namespace kinora::fields {
namespace {

constexpr std::size_t kChunk = 2048;
/// Longest piece of a ray, in cells of live space, that is taken as straight.
constexpr double kPieceCells = 4;

Eigen::Vector3d pixel_ray(const StoredFrame& frame, const StoredPixel& pixel) {
  return frame.camera.camera_to_world.linear() * frame.camera.intrinsics.unproject(pixel.u, pixel.v, 1.0);
}

FieldRay relative_ray(const FieldBox& box, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
  FieldRay ray{};
  Eigen::Map<Eigen::Vector3f>(ray.origin.data()) = ((origin - box.origin) / box.side).cast<float>();
  Eigen::Map<Eigen::Vector3f>(ray.direction.data()) = (direction / box.side).cast<float>();
  ray.metres_per_depth = static_cast<float>(direction.norm());
  return ray;
}

// Calls body(index, part) for the pixels of a frame on all threads; the parts are appended to `out` in order.
template <class Body> void for_pixels(const StoredFrame& frame, LargeBuffer<WarpedPixel>& out, const Body& body) {
  const std::size_t count = frame.end - frame.begin;
  std::vector<std::vector<WarpedPixel>> parts(chunk_count(count, kChunk));
  parallel_for(count, kChunk, [&](const Chunk& chunk) {
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) body(frame.begin + i, parts[chunk.index]);
  });
  for (const auto& part : parts) out.insert(out.end(), part.begin(), part.end());
}

bool is_lost(const tracking::Motion& motion, const StoredFrame& frame) {
  return motion.health(static_cast<std::size_t>(frame.frame)) == tracking::Health::kLost;
}

/// Pieces of one ray that lie in live occupied space, none longer than is straight.
class Pieces {
public:
  Pieces(const LiveSpace& live, const FieldRay& ray, float near_depth, float far_depth)
      : live_(live), ray_(ray), walk_(live.distances(), ray, near_depth, far_depth),
        longest_(static_cast<float>(kPieceCells * live.box().side / live.distances().resolution()) /
                 ray.metres_per_depth) {}

  bool next(WarpedPixel& piece) {
    while (true) {
      if (!(interval_.begin < interval_.end) && !walk_.next(interval_)) return false;
      piece.piece = {interval_.begin, std::min(interval_.begin + longest_, interval_.end)};
      interval_.begin = piece.piece.end;
      const float middle = 0.5F * (piece.piece.begin + piece.piece.end);
      std::array<float, 3> at{};
      for (std::size_t a = 0; a < 3; ++a) at[a] = ray_.origin[a] + middle * ray_.direction[a];
      if (const LiveSpace::Map* map = live_.map_at(at)) {
        piece.ray = to_canonical(*map, ray_);
        return true;
      }
    }
  }

private:
  const LiveSpace& live_;
  FieldRay ray_;
  OccupiedIntervals walk_;
  float longest_;
  Interval interval_{0, 0};
};

} // namespace

LargeBuffer<WarpedPixel> warp_measured_pixels(const PixelStore& pixels, int label, const tracking::Motion& motion,
                                              const FieldConfig& config) {
  LargeBuffer<WarpedPixel> own;
  for (const StoredFrame& frame : pixels.frames()) {
    if (is_lost(motion, frame)) continue;
    const tracking::Warp warp = motion.warp(frame.frame);
    for_pixels(frame, own, [&](std::size_t i, std::vector<WarpedPixel>& part) {
      const StoredPixel& pixel = pixels.pixels()[i];
      if (pixel.label != label || pixel.depth == 0) return;
      const double depth = std::abs(pixel.depth);
      const Eigen::Vector3d direction = pixel_ray(frame, pixel);
      const auto canonical = warp.to_canonical(frame.camera.camera_to_world.translation() + depth * direction);
      if (!canonical) return;
      const Eigen::Vector3d carried = warp.at(*canonical)->linear().transpose() * direction;
      part.push_back({static_cast<std::uint32_t>(i),
                      relative_ray(config.box, *canonical - depth * carried, carried),
                      {0, kFarthest}});
    });
  }
  return own;
}

WarpedSpace warp_occupied_space(const PixelStore& pixels, int label, const tracking::Motion& motion,
                                const FieldConfig& config, const Occupancy& occupancy, float near_depth) {
  WarpedSpace space;
  for (const StoredFrame& frame : pixels.frames()) {
    if (is_lost(motion, frame)) continue;
    const LiveSpace live(config, occupancy, motion.warp(frame.frame));
    const auto live_ray = [&](const StoredPixel& pixel) {
      return relative_ray(live.box(), frame.camera.camera_to_world.translation(), pixel_ray(frame, pixel));
    };
    for_pixels(frame, space.unmeasured, [&](std::size_t i, std::vector<WarpedPixel>& part) {
      const StoredPixel& pixel = pixels.pixels()[i];
      if (pixel.label != label || label == 0 || pixel.depth != 0) return;
      Pieces pieces(live, live_ray(pixel), near_depth, kFarthest);
      WarpedPixel first{static_cast<std::uint32_t>(i), {}, {}};
      if (pieces.next(first)) part.push_back(first);
    });
    for_pixels(frame, space.before, [&](std::size_t i, std::vector<WarpedPixel>& part) {
      const StoredPixel& pixel = pixels.pixels()[i];
      const bool own = pixel.label == label;
      if (own && pixel.depth <= 0) return;
      const float end = own ? pixel.depth - surface_band(config, pixel.depth) : empty_until(pixel);
      Pieces pieces(live, live_ray(pixel), near_depth, end);
      WarpedPixel piece{static_cast<std::uint32_t>(i), {}, {}};
      while (pieces.next(piece)) part.push_back(piece);
    });
  }
  return space;
}

} // namespace kinora::fields
