#include "fields/training/space_carving.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "fields/sampling/pixel_map.h"
#include "fields/sampling/surface_band.h"
#include "motion/bulk_warp.h"

namespace kinora::fields {
namespace {

using Cell = std::array<int, 3>;

constexpr std::size_t kMaxFrames = 64;
constexpr std::size_t kPointsPerChunk = 512;
constexpr double kThickness = 2; // cells: a surface is occupied some cells deep
constexpr int kMinRatio = 2;     // times as many looks see past a cell as meet it

// Connected parts, each cell once, the largest first. Empties the occupancy.
std::vector<std::vector<Cell>> take_connected_components(Occupancy& occupancy) {
  const int r = occupancy.resolution();
  const auto width = static_cast<std::size_t>(r);
  std::vector<std::vector<Cell>> parts;
  std::vector<std::uint64_t>& words = occupancy.words();
  for (std::size_t w = 0; w < words.size(); ++w) {
    while (words[w] != 0) {
      const std::size_t i = 64 * w + static_cast<std::size_t>(std::countr_zero(words[w]));
      std::vector<Cell> part{
          {static_cast<int>(i % width), static_cast<int>(i / width % width), static_cast<int>(i / (width * width))}};
      occupancy.set(part[0][0], part[0][1], part[0][2], false);
      for (std::size_t next = 0; next < part.size(); ++next) {
        const Cell at = part[next];
        for (int z = std::max(at[2] - 1, 0); z <= std::min(at[2] + 1, r - 1); ++z) {
          for (int y = std::max(at[1] - 1, 0); y <= std::min(at[1] + 1, r - 1); ++y) {
            for (int x = std::max(at[0] - 1, 0); x <= std::min(at[0] + 1, r - 1); ++x) {
              if (!occupancy.at(x, y, z)) continue;
              occupancy.set(x, y, z, false);
              part.push_back({x, y, z});
            }
          }
        }
      }
      parts.push_back(std::move(part));
    }
  }
  std::stable_sort(parts.begin(), parts.end(), [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return parts;
}

/// Looks that meet the layer at a cell, and looks that see past it.
struct Votes {
  int hits = 0;
  int misses = 0;

  void add(const Votes& other) {
    hits += other.hits;
    misses += other.misses;
  }
};

/// What one pixel tells of a cell at a depth.
Votes vote_of(const StoredPixel& pixel, const LayerObservations& layer, float depth, float thickness) {
  const float tolerance = kSensorNoise.three_sigma(depth) + thickness;
  if (!layer.is_foreground(pixel)) return {0, depth + tolerance < free_space_until(pixel) ? 1 : 0};
  if (!pixel.depth.is_known() || pixel.depth.is_extended()) return {}; // what others measure there stands
  const float beyond = pixel.depth.metres() - depth;
  return {std::abs(beyond) < tolerance ? 1 : 0, beyond >= tolerance ? 1 : 0};
}

/// What a frame tells of a cell, in the camera's frame: what the pixel in its middle does, and that it is past it only
/// if all of it lies before what is farther. Of the pixels about that, some may not be stored.
Votes vote_of(const Eigen::Vector3d& p, double side, const Intrinsics& k, const PixelMap& map,
              const LayerObservations& layer) {
  if (!(p.z() > side)) return {};
  const Eigen::Vector2d at = k.project(p);
  if (!(at.x() > -0.5 && at.y() > -0.5 && at.x() < k.width && at.y() < k.height)) return {};
  const int u = static_cast<int>(std::lround(at.x()));
  const int v = static_cast<int>(std::lround(at.y()));
  const auto votes_of = [&](const StoredPixel& pixel) {
    return vote_of(pixel, layer, static_cast<float>(p.z()), static_cast<float>(kThickness * side));
  };
  const StoredPixel* middle = map.at(u, v);
  if (middle == nullptr) return {};
  Votes votes = votes_of(*middle);
  if (votes.misses == 0) return votes;
  const int reach = static_cast<int>(std::ceil(side / 2 * k.fx / p.z()));
  for (const int dv : {-reach, 0, reach}) {
    for (const int du : {-reach, 0, reach}) {
      const StoredPixel* pixel = map.at(u + du, v + dv);
      if (pixel == nullptr) continue;
      const Votes neighbour = votes_of(*pixel);
      if (neighbour.hits > 0) return neighbour;
      votes.misses = std::min(votes.misses, neighbour.misses);
    }
  }
  return votes;
}

/// Points of a layer, in any frame.
class WarpedPoints {
public:
  WarpedPoints(const motion::Motion& motion, std::vector<Eigen::Vector3d> points)
      : motion_(motion), points_(std::move(points)) {
    if (motion.graph() == nullptr) return;
    table_ = std::make_shared<const motion::InfluenceTable>(motion.graph());
    for (const Eigen::Vector3d& point : points_) {
      const Eigen::Vector3f p = (point - table_->origin()).cast<float>();
      canonical_.push_back({p.x(), p.y(), p.z()});
    }
  }

  std::size_t size() const { return points_.size(); }
  /// In the world; not a number where nothing moves the point.
  std::vector<Eigen::Vector3d> at(int frame) const {
    std::vector<Eigen::Vector3d> world(points_.size());
    const motion::Warp warp = motion_.warp(frame);
    std::optional<motion::BulkWarp> bulk;
    if (table_ != nullptr) bulk.emplace(table_, warp);
    parallel_for(world.size(), kPointsPerChunk, [&](const Chunk& chunk) {
      if (!bulk) {
        for (std::size_t i = chunk.begin; i < chunk.end; ++i) world[i] = warp.rigid() * points_[i];
        return;
      }
      std::vector<motion::BulkWarp::WarpedPoint> there(chunk.end - chunk.begin);
      bulk->to_world(std::span(canonical_).subspan(chunk.begin, there.size()), there.data());
      for (std::size_t k = 0; k < there.size(); ++k) {
        world[chunk.begin + k] = Eigen::Vector3f(there[k].point.data()).cast<double>() + bulk->world_origin();
      }
    });
    return world;
  }

private:
  const motion::Motion& motion_;
  std::vector<Eigen::Vector3d> points_;
  std::shared_ptr<const motion::InfluenceTable> table_; // of a layer that deforms
  std::vector<std::array<float, 3>> canonical_;         // relative to its origin
};

std::vector<Votes> votes_on(const WarpedPoints& points, const LayerObservations& layer, double side) {
  std::vector<Votes> votes(points.size());
  const std::size_t frames = layer.pixels.frames().size();
  const std::size_t used_frames = std::min(frames, kMaxFrames);
  for (std::size_t n = 0; n < used_frames; ++n) {
    const StoredFrame& frame = layer.pixels.frames()[n * frames / used_frames];
    if (layer.is_lost(frame)) continue;
    const PixelMap map(layer.pixels, frame);
    const SE3 camera_from_world = frame.camera.camera_to_world.inverse();
    const std::vector<Eigen::Vector3d> world = points.at(frame.frame);
    parallel_for(world.size(), kPointsPerChunk, [&](const Chunk& chunk) {
      for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
        votes[i].add(vote_of(camera_from_world * world[i], side, frame.camera.intrinsics, map, layer));
      }
    });
  }
  return votes;
}

} // namespace

std::size_t carve_free_space(const LayerObservations& layer, Field& field) {
  const std::vector<std::vector<Cell>> parts = take_connected_components(field.occupancy);
  const double side = field.config.box.side / field.config.occupancy_resolution;
  std::vector<Eigen::Vector3d> points;
  for (const auto& part : parts) {
    for (const Cell& cell : part) {
      points.push_back(field.config.box.origin + side * Eigen::Vector3d(cell[0] + 0.5, cell[1] + 0.5, cell[2] + 0.5));
    }
  }
  const std::vector<Votes> votes = votes_on({layer.motion, std::move(points)}, layer, side);
  std::size_t carved = 0;
  auto vote = votes.begin();
  for (const auto& part : parts) {
    Votes all;
    for (std::size_t k = 0; k < part.size(); ++k) all.add(vote[static_cast<std::ptrdiff_t>(k)]);
    const bool is_isolated = &part != &parts.front() && all.misses > all.hits;
    for (const Cell& cell : part) {
      if (is_isolated || vote->misses > kMinRatio * vote->hits) {
        ++carved;
      } else {
        field.occupancy.set(cell[0], cell[1], cell[2]);
      }
      ++vote;
    }
  }
  return carved;
}

} // namespace kinora::fields
