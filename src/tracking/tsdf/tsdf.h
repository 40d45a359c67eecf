// A truncated signed distance field in a sparse set of bricks of 8³ voxels, fused from depth images.
// Source: Curless and Levoy, SIGGRAPH 1996; Nießner et al., "Real-time 3D Reconstruction at Scale using Voxel Hashing",
// ACM TOG 32(6), 2013. The distance to a voxel is taken to the fitted plane of the pixel, not along the ray.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "core/camera.h"
#include "tracking/tsdf/warped_brick.h"
#include "tracking/view/depth_planes.h"

namespace kinora::tracking {

struct TsdfConfig {
  double voxel_size = 0.004; ///< metres
  double truncation = 0.02;  ///< metres; 4–7 voxels
  float max_weight = 64;     ///< older observations fade once a voxel has this much
};

/// Distance and unit normal (pointing out of the surface).
struct TsdfSample {
  double distance; ///< metres, positive in front of the surface
  Eigen::Vector3d normal;
};

/// A point of the zero level, relative to the volume's origin.
struct SurfacePoint {
  Eigen::Vector3f position;
  Eigen::Vector3f normal;  ///< unit, pointing out of the surface
  float intensity;         ///< as given to integrate, or 0
  float weight;            ///< the smaller of the two voxels' weights
  std::uint32_t brick = 0; ///< that it lies in
};

/// Points are in double, in the volume's space; inside, everything is relative to `origin`, so that accuracy does not
/// depend on where the origin lies. Thread-safe to read; integrate needs exclusive use.
/// The same calls give the same bits and the same order of bricks for any number of threads.
class TsdfVolume {
public:
  static constexpr int kBrickSide = 8;
  static constexpr int kBrickVoxels = kBrickSide * kBrickSide * kBrickSide;

  /// `origin`: a point near the surface. Throws Error(kFailure) if sizes are not positive and finite.
  TsdfVolume(const TsdfConfig& config, const Eigen::Vector3d& origin);

  /// Fuses the planes of one image (all of one size, that of the intrinsics). `intensity` may be empty (then nothing is
  /// fused of it). Pixels without plane teach nothing, neither surface nor emptiness.
  /// Throws Error(kFailure) if sizes differ or the pose is not finite.
  void integrate(const DepthPlanes& view, const Image<float>& intensity, const Intrinsics& intrinsics,
                 const SE3& camera_to_volume);

  /// Where points of a bent volume (of that brick, relative to the origin) are in the camera; NaN where space is empty.
  using BrickWarp = std::function<void(std::size_t brick, const BrickCorners& points, BrickCorners& in_camera)>;
  /// Which place of the volume (relative to the origin) a pixel shows: one for each cell of stride × stride pixels, in
  /// the first three of four channels; NaN where the pixels show nothing of it.
  struct CanonicalMap {
    int stride = 4;
    Image<float> of_cell;
  };
  /// Fuses one image into a volume that has been bent since: each voxel is carried into the camera and averaged with
  /// the distance there. A voxel learns only from pixels whose cell shows a place near it, and nothing, not even
  /// emptiness, farther than the truncation from what is measured: the bending may be wrong. The bending is taken at
  /// every fourth voxel and in between trilinearly; it must be thread-safe. Bricks with a mark in `skipped` (one for
  /// each brick, or for the first ones) learn nothing. Returns a mark for each brick that may have learnt something.
  /// Throws Error(kFailure) if sizes differ.
  std::vector<std::uint8_t> integrate_non_rigid(const DepthPlanes& view, const Image<float>& intensity,
                                                const Intrinsics& intrinsics, const BrickWarp& to_camera,
                                                const CanonicalMap& positions,
                                                std::span<const std::uint8_t> skipped = {});

  /// Makes the bricks that come within the truncation of a surface: space for what resample() brings.
  void make_bricks(std::span<const SurfacePoint> surface);
  /// Where points of a brick (relative to the origin) are in another volume (relative to its origin); NaN: nowhere.
  using PointWarp =
      std::function<void(std::size_t brick, const motion::PointLanes& points, motion::PointLanes& in_other)>;
  /// Each voxel takes what the other volume has, trilinearly, in the place it is carried to; where that is nowhere or
  /// was never seen, it keeps what it has. `to_other` must be thread-safe. Same bits for any number of threads.
  void resample(const TsdfVolume& other, const PointWarp& to_other);

  /// Trilinear; nothing where one of the eight voxels around was never seen.
  std::optional<double> distance(const Eigen::Vector3d& point) const;
  std::optional<double> intensity(const Eigen::Vector3d& point) const;
  /// Distance, and the normal by central differences of ±1 voxel where they are seen, else of the one cell.
  std::optional<TsdfSample> sample(const Eigen::Vector3d& point) const;

  /// Zero crossings along the voxel edges, brick by brick in the order of their making.
  std::vector<SurfacePoint> surface_points(float min_weight = 0) const;
  /// The same of one brick.
  void append_surface(std::size_t brick, float min_weight, std::vector<SurfacePoint>& points) const;

  const TsdfConfig& config() const { return config_; }
  const Eigen::Vector3d& origin() const { return origin_; }
  /// Bricks are numbered in the order of their making.
  std::size_t brick_count() const { return bricks_.size(); }
  double brick_size() const { return kBrickSide * config_.voxel_size; } ///< metres
  /// Relative to the origin.
  Eigen::Vector3d brick_centre(std::size_t brick) const;

private:
  struct Brick {
    std::array<int, 3> coordinate;
    std::array<float, kBrickVoxels> distance{}; ///< metres
    std::array<float, kBrickVoxels> weight{};
    std::array<float, kBrickVoxels> intensity{};
  };
  struct Slot {
    std::array<int, 3> coordinate{};
    std::int32_t brick = -1;
  };
  struct View;
  struct WarpedView;
  struct Neighbourhood;
  struct Limits;
  struct Block;

  void read(const Eigen::Vector3d& position, Brick& brick, std::size_t voxel) const;
  std::int32_t find(const std::array<int, 3>& coordinate) const;
  std::int32_t find_or_insert(const std::array<int, 3>& coordinate);
  void grow_table();
  std::vector<std::uint8_t> allocate_bricks(const View& view);
  bool holds_surface(const Brick& brick, const Limits& limits) const;
  bool may_be_seen(const Brick& brick, const View& view) const;
  void update(Brick& brick, const View& view) const;
  std::vector<std::uint8_t> touch_around(const CanonicalMap& positions, float reach);
  void update_warped(std::size_t number, const WarpedView& view);
  Eigen::Vector3d to_grid(const Eigen::Vector3d& point) const { return (point - origin_) / config_.voxel_size; }

  TsdfConfig config_;
  Eigen::Vector3d origin_;
  std::vector<std::unique_ptr<Brick>> bricks_;
  std::vector<Slot> table_; ///< open addressing, a power of two
};

} // namespace kinora::tracking
