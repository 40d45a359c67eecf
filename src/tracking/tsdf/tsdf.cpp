#include "tracking/tsdf/tsdf.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/error.h"
#include "core/parallel.h"
#include "core/random.h"
#include "tracking/view/visibility.h"

namespace kinora::tracking {
namespace {

constexpr int kSide = TsdfVolume::kBrickSide;
constexpr std::size_t kBricksPerChunk = 64;

std::size_t hash_of(const std::array<int, 3>& c) {
  const auto key = static_cast<std::uint64_t>(static_cast<std::uint32_t>(c[0]) & 0x1FFFFFU) |
                   static_cast<std::uint64_t>(static_cast<std::uint32_t>(c[1]) & 0x1FFFFFU) << 21U |
                   static_cast<std::uint64_t>(static_cast<std::uint32_t>(c[2]) & 0x1FFFFFU) << 42U;
  return mix64(key);
}

// Bilinear inside the image, the nearest border pixel outside.
float interpolate(const Image<float>& image, float u, float v) {
  u = std::clamp(u, 0.0F, static_cast<float>(image.width() - 1));
  v = std::clamp(v, 0.0F, static_cast<float>(image.height() - 1));
  const int u0 = std::min(static_cast<int>(u), std::max(0, image.width() - 2));
  const int v0 = std::min(static_cast<int>(v), std::max(0, image.height() - 2));
  const int u1 = std::min(u0 + 1, image.width() - 1);
  const int v1 = std::min(v0 + 1, image.height() - 1);
  const float fu = u - static_cast<float>(u0);
  const float fv = v - static_cast<float>(v0);
  const float top = image.at(u0, v0) * (1 - fu) + image.at(u1, v0) * fu;
  const float bottom = image.at(u0, v1) * (1 - fu) + image.at(u1, v1) * fu;
  return top * (1 - fv) + bottom * fv;
}

} // namespace

/// One image on its way into the volume; everything in float and relative to the volume's origin.
struct TsdfVolume::View {
  const Image<float>& planes;
  const Image<float>& weights;
  const Image<float>& intensity;
  float fx, fy, cx, cy;
  Eigen::Matrix3f rotation;    ///< volume to camera
  Eigen::Vector3f translation; ///< volume's origin in the camera
};

TsdfVolume::TsdfVolume(const TsdfConfig& config, const Eigen::Vector3d& origin) : config_(config), origin_(origin) {
  const bool usable = config.voxel_size > 0 && std::isfinite(config.voxel_size) &&
                      config.truncation >= config.voxel_size && std::isfinite(config.truncation) &&
                      config.max_weight > 0 && origin.allFinite();
  if (!usable) {
    throw Error(ErrorCode::kFailure, "a distance field needs a positive voxel size and weight, a truncation of at "
                                     "least one voxel and a finite origin");
  }
  table_.resize(1024);
}

Eigen::Vector3d TsdfVolume::brick_centre(std::size_t brick) const {
  return (Eigen::Map<const Eigen::Array3i>(bricks_[brick]->coordinate.data()).cast<double>() + 0.5) * brick_size();
}

std::int32_t TsdfVolume::find(const std::array<int, 3>& coordinate) const {
  const std::size_t mask = table_.size() - 1;
  for (std::size_t i = hash_of(coordinate) & mask;; i = (i + 1) & mask) {
    const Slot& slot = table_[i];
    if (slot.brick < 0 || slot.coordinate == coordinate) return slot.brick;
  }
}

std::int32_t TsdfVolume::find_or_insert(const std::array<int, 3>& coordinate) {
  const std::int32_t found = find(coordinate);
  if (found >= 0) return found;
  if (2 * (bricks_.size() + 1) > table_.size()) grow_table();
  const auto index = static_cast<std::int32_t>(bricks_.size());
  bricks_.push_back(std::make_unique<Brick>());
  bricks_.back()->coordinate = coordinate;
  const std::size_t mask = table_.size() - 1;
  std::size_t i = hash_of(coordinate) & mask;
  while (table_[i].brick >= 0) i = (i + 1) & mask;
  table_[i] = {coordinate, index};
  return index;
}

void TsdfVolume::grow_table() {
  std::vector<Slot> old(2 * table_.size());
  old.swap(table_);
  const std::size_t mask = table_.size() - 1;
  for (const Slot& slot : old) {
    if (slot.brick < 0) continue;
    std::size_t i = hash_of(slot.coordinate) & mask;
    while (table_[i].brick >= 0) i = (i + 1) & mask;
    table_[i] = slot;
  }
}

// Makes the bricks within the truncation of the measured surface; returns a mark for each that this image touches.
std::vector<std::uint8_t> TsdfVolume::allocate_bricks(const View& view) {
  const float brick_size = static_cast<float>(kSide * config_.voxel_size);
  const float truncation = static_cast<float>(config_.truncation);
  const int samples = 1 + static_cast<int>(std::ceil(2 * truncation / (0.5F * brick_size)));
  // A quarter of a brick between the rays at 4 m: what falls between two rays belongs to a brick that one of them hits.
  const int stride = std::clamp(static_cast<int>(0.25F * brick_size * view.fx / 4.0F), 1, 4);
  std::vector<std::uint8_t> allocated(bricks_.size(), 0);
  std::array<int, 3> last{};
  bool has_last = false;
  for (int v = 0; v < view.planes.height(); v += stride) {
    for (int u = 0; u < view.planes.width(); u += stride) {
      if (view.weights.at(u, v) <= 0) continue;
      const float* plane = view.planes.pixel(u, v);
      const Eigen::Vector3f ray((static_cast<float>(u) - view.cx) / view.fx,
                                (static_cast<float>(v) - view.cy) / view.fy, 1.0F);
      const float normal_dot_ray = plane[0] * ray.x() + plane[1] * ray.y() + plane[2];
      const Eigen::Vector3f point = ray * (-plane[3] / normal_dot_ray);
      const Eigen::Vector3f direction = ray.normalized();
      for (int s = 0; s < samples; ++s) {
        const float along = truncation * (2.0F * static_cast<float>(s) / static_cast<float>(samples - 1) - 1.0F);
        const Eigen::Vector3f local =
            view.rotation.transpose() * (point + along * direction - view.translation) / brick_size;
        const std::array<int, 3> coordinate = {static_cast<int>(std::floor(local.x())),
                                               static_cast<int>(std::floor(local.y())),
                                               static_cast<int>(std::floor(local.z()))};
        if (has_last && coordinate == last) continue;
        last = coordinate;
        has_last = true;
        const auto index = static_cast<std::size_t>(find_or_insert(coordinate));
        if (index >= allocated.size()) allocated.resize(index + 1, 0);
        allocated[index] = 1;
      }
    }
  }
  return allocated;
}

// Whether the image may say something about a brick that no ray has touched: that it is empty now.
bool TsdfVolume::may_be_seen(const Brick& brick, const View& view) const {
  const float size = static_cast<float>(kSide * config_.voxel_size);
  const Eigen::Vector3f centre =
      (Eigen::Vector3f(static_cast<float>(brick.coordinate[0]), static_cast<float>(brick.coordinate[1]),
                       static_cast<float>(brick.coordinate[2])) +
       Eigen::Vector3f::Constant(0.5F)) *
      size;
  const Eigen::Vector3f p = view.rotation * centre + view.translation;
  if (p.z() < size) return false;
  const float u = view.fx * p.x() / p.z() + view.cx + 0.5F;
  const float v = view.fy * p.y() / p.z() + view.cy + 0.5F;
  if (!(u >= 0 && v >= 0 && u < static_cast<float>(view.weights.width()) &&
        v < static_cast<float>(view.weights.height()))) {
    return false;
  }
  const int pixel_u = static_cast<int>(u);
  const int pixel_v = static_cast<int>(v);
  if (view.weights.at(pixel_u, pixel_v) <= 0) return false;
  const float* plane = view.planes.pixel(pixel_u, pixel_v);
  return plane[0] * p.x() + plane[1] * p.y() + plane[2] * p.z() + plane[3] > 0;
}

void TsdfVolume::update(Brick& brick, const View& view) const {
  const float voxel = static_cast<float>(config_.voxel_size);
  const float truncation = static_cast<float>(config_.truncation);
  const Eigen::Vector3f step = view.rotation.col(0) * voxel;
  const float max_u = static_cast<float>(view.weights.width()) - 0.5F;
  const float max_v = static_cast<float>(view.weights.height()) - 0.5F;
  std::size_t i = 0;
  for (int z = 0; z < kSide; ++z) {
    for (int y = 0; y < kSide; ++y) {
      const Eigen::Vector3f first(static_cast<float>(brick.coordinate[0] * kSide),
                                  static_cast<float>(brick.coordinate[1] * kSide + y),
                                  static_cast<float>(brick.coordinate[2] * kSide + z));
      Eigen::Vector3f p = view.rotation * (first * voxel) + view.translation;
      for (int x = 0; x < kSide; ++x, ++i, p += step) {
        if (p.z() < static_cast<float>(kNearestDepth)) continue;
        const float inverse = 1.0F / p.z();
        const float u = view.fx * p.x() * inverse + view.cx;
        const float v = view.fy * p.y() * inverse + view.cy;
        if (!(u > -0.5F && v > -0.5F && u < max_u && v < max_v)) continue;
        const float shifted_u = u + 0.5F;
        const float shifted_v = v + 0.5F;
        const int pixel_u = static_cast<int>(shifted_u);
        const int pixel_v = static_cast<int>(shifted_v);
        float weight = view.weights.at(pixel_u, pixel_v);
        if (weight <= 0) continue;
        const float* plane = view.planes.pixel(pixel_u, pixel_v);
        const float distance = plane[0] * p.x() + plane[1] * p.y() + plane[2] * p.z() + plane[3];
        if (distance <= -truncation) continue;
        // What lies behind the surface is a guess, worse with every step: near an edge it is outside again.
        if (distance < 0) {
          const float trust = 1.0F + distance / truncation;
          weight *= trust * trust;
        }
        const float old = brick.weight[i];
        const float share = weight / (old + weight);
        brick.distance[i] += share * (std::min(distance, truncation) - brick.distance[i]);
        if (!view.intensity.empty() && distance < truncation) {
          brick.intensity[i] += share * (interpolate(view.intensity, u, v) - brick.intensity[i]);
        }
        brick.weight[i] = std::min(old + weight, config_.max_weight);
      }
    }
  }
}

void TsdfVolume::integrate(const DepthPlanes& view, const Image<float>& intensity, const Intrinsics& intrinsics,
                           const SE3& camera_to_volume) {
  const bool fits = view.planes.width() == intrinsics.width && view.planes.height() == intrinsics.height &&
                    view.weights.same_size(view.planes) && (intensity.empty() || intensity.same_size(view.planes));
  if (!fits) {
    throw Error(ErrorCode::kFailure, "the images to fuse differ in size from each other or from their camera");
  }
  // Beyond a hundred kilometres from the origin, brick coordinates would overflow.
  if (!((camera_to_volume.translation() - origin_).norm() < 1e5) || !camera_to_volume.linear().allFinite()) {
    throw Error(ErrorCode::kFailure, "the pose of an image to fuse is not finite or lies too far from the volume");
  }
  const SE3 volume_to_camera = camera_to_volume.inverse();
  const View local{view.planes,
                   view.weights,
                   intensity,
                   static_cast<float>(intrinsics.fx),
                   static_cast<float>(intrinsics.fy),
                   static_cast<float>(intrinsics.cx),
                   static_cast<float>(intrinsics.cy),
                   volume_to_camera.linear().cast<float>(),
                   (volume_to_camera * origin_).cast<float>()};
  const std::vector<std::uint8_t> allocated = allocate_bricks(local);
  parallel_for(bricks_.size(), kBricksPerChunk, [&](const Chunk& chunk) {
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      const bool is_allocated = i < allocated.size() && allocated[i] != 0;
      if (is_allocated || may_be_seen(*bricks_[i], local)) update(*bricks_[i], local);
    }
  });
}

} // namespace kinora::tracking
