#include "fields/warped_pixels.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/parallel.h"
#include "core/random.h"
#include "fields/surface_band.h"
#include "tracking/bulk_warp.h"

namespace kinora::fields {
namespace {

using tracking::BulkWarp;

constexpr std::size_t kChunk = 2048;

Eigen::Vector3d pixel_ray(const StoredFrame& frame, const StoredPixel& pixel) {
  return frame.camera.camera_to_world.linear() * frame.camera.intrinsics.unproject(pixel.u, pixel.v, 1.0);
}

std::array<float, 3> to_array(const Eigen::Vector3d& v) {
  const Eigen::Vector3f single = v.cast<float>();
  return {single.x(), single.y(), single.z()};
}

Eigen::Vector3d to_vector(const std::array<float, 3>& v) { return Eigen::Vector3f(v.data()).cast<double>(); }

FieldRay relative_ray(const FieldBox& box, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                      double metres_per_depth) {
  return {to_array((origin - box.origin) / box.side), to_array(direction / box.side),
          static_cast<float>(metres_per_depth)};
}

bool is_lost(const tracking::Motion& motion, const StoredFrame& frame) {
  return motion.health(static_cast<std::size_t>(frame.frame)) == tracking::Health::kLost;
}

/// Lists that are filled chunk by chunk on all threads and kept in the order of the chunks.
class Parts {
public:
  // Calls body(chunk, part) for chunks of [0, count).
  template <class Body> void append(std::size_t count, const Body& body) {
    const std::size_t first = parts_.size();
    parts_.resize(first + chunk_count(count, kChunk));
    parallel_for(count, kChunk, [&](const Chunk& chunk) { body(chunk, parts_[first + chunk.index]); });
  }

  LargeBuffer<WarpedPixel> joined() {
    std::size_t size = 0;
    for (const auto& part : parts_) size += part.size();
    LargeBuffer<WarpedPixel> all;
    all.reserve(size);
    for (auto& part : parts_) {
      all.insert(all.end(), part.begin(), part.end());
      part = {};
    }
    return all;
  }

private:
  std::vector<std::vector<WarpedPixel>> parts_;
};

/// Middles of the occupied cells, relative to the origin of canonical points.
std::vector<Eigen::Vector3d> occupied_places(const Occupancy& occupancy, const FieldBox& box,
                                             const Eigen::Vector3d& origin) {
  std::vector<Eigen::Vector3d> places;
  const auto r = static_cast<std::size_t>(occupancy.resolution());
  for (std::size_t w = 0; w < occupancy.words().size(); ++w) {
    for (std::uint64_t bits = occupancy.words()[w]; bits != 0; bits &= bits - 1) {
      const std::size_t cell = w * 64 + static_cast<std::size_t>(std::countr_zero(bits));
      const std::size_t x = cell % r;
      const std::size_t y = cell / r % r;
      const std::size_t z = cell / (r * r);
      const Eigen::Array3d at(static_cast<double>(x), static_cast<double>(y), static_cast<double>(z));
      places.emplace_back(box.origin - origin + box.side / static_cast<double>(r) * (at + 0.5).matrix());
    }
  }
  return places;
}

/// A point of an occupied cell in one frame.
struct CarriedPlace {
  std::array<float, 3> canonical; ///< relative to the origin of canonical points
  BulkWarp::Carried there;
  std::uint16_t u, v; ///< the pixel that looks through it
  float depth;        ///< 0: the camera does not see it
};

/// One random point of each occupied cell, carried into a frame.
class CarriedSpace {
public:
  CarriedSpace(const Occupancy& occupancy, const FieldBox& box, const Eigen::Vector3d& canonical_origin)
      : box_(box), cell_(box.side / occupancy.resolution()),
        centres_(occupied_places(occupancy, box, canonical_origin)), places_(centres_.size()) {}

  double cell() const { return cell_; }
  const std::vector<CarriedPlace>& places() const { return places_; }

  void carry(const StoredFrame& frame, const BulkWarp& warp) {
    frame_ = &frame;
    camera_ = frame.camera.camera_to_world.translation() - warp.world_origin();
    canonical_from_box_ = warp.canonical_origin() - box_.origin;
    SE3 camera_to_world = frame.camera.camera_to_world;
    camera_to_world.translation() = camera_;
    const SE3 world_to_camera = camera_to_world.inverse();
    parallel_for(places_.size(), kChunk, [&](const Chunk& chunk) {
      Random random(0x5BACE + static_cast<std::uint64_t>(frame.frame), chunk.index);
      std::vector<std::array<float, 3>> canonical;
      canonical.reserve(kChunk);
      for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
        const double x = random.uniform();
        const double y = random.uniform();
        const double z = random.uniform();
        canonical.push_back(to_array(centres_[i] + cell_ * Eigen::Vector3d(x - 0.5, y - 0.5, z - 0.5)));
      }
      std::vector<BulkWarp::Carried> carried(canonical.size());
      warp.to_world(canonical, carried.data());
      for (std::size_t k = 0; k < canonical.size(); ++k) {
        CarriedPlace& place = places_[chunk.begin + k];
        place = {canonical[k], carried[k], 0, 0, 0};
        see(world_to_camera * to_vector(carried[k].point), place);
      }
    });
  }

  /// The ray of a pixel that looks through the place, as it passes there.
  FieldRay ray(const CarriedPlace& place, const StoredPixel& pixel) const {
    const Eigen::Vector3d direction = pixel_ray(*frame_, pixel);
    const Eigen::Quaterniond back = Eigen::Quaternionf(place.there.rotation.data()).cast<double>().conjugate();
    const Eigen::Vector3d origin =
        canonical_from_box_ + to_vector(place.canonical) + back * (camera_ - to_vector(place.there.point));
    return {to_array(origin / box_.side), to_array(back * direction / box_.side), static_cast<float>(direction.norm())};
  }

private:
  void see(const Eigen::Vector3d& in_camera, CarriedPlace& place) const {
    const Intrinsics& k = frame_->camera.intrinsics;
    if (!(in_camera.z() > 0)) return;
    const double u = k.fx * in_camera.x() / in_camera.z() + k.cx + 0.5;
    const double v = k.fy * in_camera.y() / in_camera.z() + k.cy + 0.5;
    if (!(u >= 0 && u < k.width && v >= 0 && v < k.height)) return;
    place.u = static_cast<std::uint16_t>(u);
    place.v = static_cast<std::uint16_t>(v);
    place.depth = static_cast<float>(in_camera.z());
  }

  FieldBox box_;
  double cell_;                          ///< metres
  std::vector<Eigen::Vector3d> centres_; ///< of the cells, relative to the origin of canonical points
  std::vector<CarriedPlace> places_;
  const StoredFrame* frame_ = nullptr;
  Eigen::Vector3d camera_;             ///< relative to the origin of world points
  Eigen::Vector3d canonical_from_box_; ///< origin of canonical points from the box's corner
};

/// For blocks of pixels about as large as a cell, the nearest place that they see.
class FirstSeen {
public:
  explicit FirstSeen(const CarriedSpace& space, const Intrinsics& camera) : places_(space.places()) {
    float nearest = kFarthest;
    for (const CarriedPlace& place : places_) {
      if (place.depth > 0) nearest = std::min(nearest, place.depth);
    }
    const double side = std::ceil(2 * space.cell() * camera.fx / static_cast<double>(nearest));
    block_ = static_cast<std::size_t>(std::clamp(side, 1.0, static_cast<double>(std::max(camera.width, 1))));
    columns_ = static_cast<std::size_t>(camera.width) / block_ + 1;
    first_.assign(columns_ * (static_cast<std::size_t>(camera.height) / block_ + 1), nullptr);
    for (const CarriedPlace& place : places_) {
      const CarriedPlace*& first = first_[block_of(place.u, place.v)];
      if (place.depth > 0 && (first == nullptr || place.depth < first->depth)) first = &place;
    }
  }

  /// nullptr if none is seen.
  const CarriedPlace* at(const StoredPixel& pixel) const { return first_[block_of(pixel.u, pixel.v)]; }

private:
  std::size_t block_of(std::size_t u, std::size_t v) const { return v / block_ * columns_ + u / block_; }

  const std::vector<CarriedPlace>& places_;
  std::size_t block_ = 1; ///< pixels
  std::size_t columns_ = 0;
  std::vector<const CarriedPlace*> first_;
};

/// How far the pixel shows that the layer is not there.
float empty_before(const StoredPixel& pixel, int label, const FieldConfig& config) {
  if (pixel.label != label) return empty_until(pixel);
  return pixel.depth > 0 ? pixel.depth - surface_band(config, pixel.depth) : 0;
}

} // namespace

LargeBuffer<WarpedPixel> warp_measured_pixels(const PixelStore& pixels, int label, const tracking::Motion& motion,
                                              const FieldConfig& config) {
  Parts own;
  const auto table = std::make_shared<const tracking::InfluenceTable>(motion.graph());
  for (const StoredFrame& frame : pixels.frames()) {
    if (is_lost(motion, frame)) continue;
    const BulkWarp warp(table, motion.warp(frame.frame));
    const Eigen::Vector3d camera = frame.camera.camera_to_world.translation() - warp.world_origin();
    own.append(frame.end - frame.begin, [&](const Chunk& chunk, std::vector<WarpedPixel>& part) {
      std::vector<std::size_t> numbers;
      std::vector<BulkWarp::Ray> rays;
      for (std::size_t i = frame.begin + chunk.begin; i < frame.begin + chunk.end; ++i) {
        const StoredPixel& pixel = pixels.pixels()[i];
        if (pixel.label != label || pixel.depth == 0) continue;
        const float depth = std::abs(pixel.depth);
        const Eigen::Vector3d direction = pixel_ray(frame, pixel);
        rays.push_back({to_array(camera + depth * direction), to_array(direction), surface_band(config, depth), 0});
        numbers.push_back(i);
      }
      std::vector<BulkWarp::CanonicalRay> canonical(rays.size());
      warp.to_canonical(rays, canonical.data());
      part.reserve(rays.size());
      for (std::size_t k = 0; k < rays.size(); ++k) {
        const BulkWarp::CanonicalRay& back = canonical[k];
        if (std::isnan(back.point[0])) continue;
        const Eigen::Vector3d direction = to_vector(back.direction);
        const double depth = std::abs(pixels.pixels()[numbers[k]].depth);
        const Eigen::Vector3d origin = to_vector(back.point) + warp.canonical_origin() - depth * direction;
        part.push_back({static_cast<std::uint32_t>(numbers[k]),
                        relative_ray(config.box, origin, direction, to_vector(rays[k].direction).norm()),
                        {0, kFarthest},
                        {to_array(to_vector(back.bends[0]) / config.box.side),
                         to_array(to_vector(back.bends[1]) / config.box.side)}});
      }
    });
  }
  return own.joined();
}

WarpedSpace warp_occupied_space(const PixelStore& pixels, int label, const tracking::Motion& motion,
                                const FieldConfig& config, const Occupancy& occupancy, float near_depth) {
  constexpr float kPieceCells = 2; // so far a ray is taken as straight
  Parts before;
  Parts unmeasured;
  const auto table = std::make_shared<const tracking::InfluenceTable>(motion.graph());
  CarriedSpace space(occupancy, config.box, table->origin());
  std::vector<std::uint32_t> stored; // per pixel of the image, 1 + index into pixels(); 0: not kept
  for (const StoredFrame& frame : pixels.frames()) {
    if (is_lost(motion, frame)) continue;
    space.carry(frame, BulkWarp(table, motion.warp(frame.frame)));
    const Intrinsics& camera = frame.camera.intrinsics;
    const auto width = static_cast<std::size_t>(camera.width);
    stored.assign(width * static_cast<std::size_t>(camera.height), 0);
    std::vector<std::uint32_t> without_depth;
    for (std::size_t i = frame.begin; i < frame.end; ++i) {
      const StoredPixel& pixel = pixels.pixels()[i];
      stored[pixel.v * width + pixel.u] = static_cast<std::uint32_t>(i) + 1;
      if (pixel.label == label && label != 0 && pixel.depth == 0)
        without_depth.push_back(static_cast<std::uint32_t>(i));
    }
    const auto piece_at = [&](const CarriedPlace& place, std::uint32_t number) {
      return WarpedPixel{number, space.ray(place, pixels.pixels()[number]), {}, {}};
    };
    const auto cell = static_cast<float>(space.cell());
    before.append(space.places().size(), [&](const Chunk& chunk, std::vector<WarpedPixel>& part) {
      for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
        const CarriedPlace& place = space.places()[i];
        if (place.depth < near_depth) continue;
        const std::uint32_t number = stored[place.v * width + place.u];
        if (number == 0) continue;
        const float end = empty_before(pixels.pixels()[number - 1], label, config);
        if (!(place.depth < end)) continue;
        WarpedPixel piece = piece_at(place, number - 1);
        const float half = 0.5F * kPieceCells * cell / piece.ray.metres_per_depth;
        piece.piece = {std::max(place.depth - half, near_depth), std::min(place.depth + half, end)};
        part.push_back(piece);
      }
    });
    if (without_depth.empty()) continue;
    const FirstSeen first(space, camera);
    unmeasured.append(without_depth.size(), [&](const Chunk& chunk, std::vector<WarpedPixel>& part) {
      for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
        const CarriedPlace* place = first.at(pixels.pixels()[without_depth[i]]);
        if (place == nullptr) continue;
        WarpedPixel piece = piece_at(*place, without_depth[i]);
        const float side = cell / piece.ray.metres_per_depth;
        piece.piece.begin = std::max(place->depth - side / 2, near_depth);
        piece.piece.end = piece.piece.begin + kPieceCells * side;
        part.push_back(piece);
      }
    });
  }
  return {unmeasured.joined(), before.joined()};
}

} // namespace kinora::fields
