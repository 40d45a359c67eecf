#include "bake/volume.h"

#include <algorithm>
#include <cmath>

#include "bake/field_sampler.h"
#include "bake/voxel_key.h"
#include "clip/shown_frames.h"
#include "core/error.h"
#include "core/linear_light.h"
#include "core/parallel.h"
#include "fields/network/vector_features.h"

namespace kinora::bake {
namespace {

constexpr float kBlack = 1e-4F;                 ///< share of light that nobody sees: voxels are no denser than for that
constexpr std::size_t kMaxVoxels = 200'000'000; ///< of a frame, before empty ones are left out

std::vector<Eigen::Vector3d> occupied_centres(const fields::Field& field) {
  const int n = field.occupancy.resolution();
  const double side = field.config.box.side / n;
  std::vector<Eigen::Vector3d> centres;
  fields::for_each_occupied(field.occupancy, [&](int x, int y, int z) {
    centres.emplace_back(field.config.box.origin + side * Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5));
  });
  return centres;
}

/// Keys of the voxels whose centres lie within `reach` of a point.
void add_ball(const Eigen::Vector3d& centre, double reach, double voxel, std::vector<VoxelKey>& keys) {
  Eigen::Matrix<std::int64_t, 3, 1> low, high;
  for (int a = 0; a < 3; ++a) {
    low[a] = static_cast<std::int64_t>(std::ceil((centre[a] - reach) / voxel));
    high[a] = static_cast<std::int64_t>(std::floor((centre[a] + reach) / voxel));
    if (low[a] < -kVoxelLimit || high[a] >= kVoxelLimit)
      throw Error(ErrorCode::kFailure, "the scene is too large for voxels so small; make them larger (-O voxel=...)");
  }
  for (std::int64_t z = low.z(); z <= high.z(); ++z) {
    for (std::int64_t y = low.y(); y <= high.y(); ++y) {
      for (std::int64_t x = low.x(); x <= high.x(); ++x) {
        const Eigen::Vector3d p =
            voxel * Eigen::Vector3d(static_cast<double>(x), static_cast<double>(y), static_cast<double>(z));
        if ((p - centre).squaredNorm() <= reach * reach) keys.push_back(voxel_key(x, y, z));
      }
    }
  }
}

void sort_unique(std::vector<VoxelKey>& keys) {
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
}

/// Voxels in which the layer may be at this instant, sorted: those near the present places of its occupied cells.
std::vector<VoxelKey> candidate_voxels(const fields::Field& field, const motion::Warp& warp, double voxel) {
  const double cell = field.config.box.side / field.occupancy.resolution();
  // Half of a cell's diagonal, and what bending may stretch it by; half of a voxel, whose samples lie off its centre.
  const double reach = std::sqrt(3.0) / 2 * cell * (warp.is_rigid() ? 1.0 : 1.3) + voxel / 2;
  const std::vector<Eigen::Vector3d> centres = occupied_centres(field);
  constexpr std::size_t kCells = 4096;
  std::vector<std::vector<VoxelKey>> found(chunk_count(centres.size(), kCells));
  parallel_for(centres.size(), kCells, [&](const Chunk& chunk) {
    std::vector<VoxelKey>& keys = found[chunk.index];
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      const auto world = warp.to_world(centres[i]);
      if (world) add_ball(*world, reach, voxel, keys);
    }
    sort_unique(keys);
  });
  std::size_t total = 0;
  for (const auto& keys : found) total += keys.size();
  if (total > kMaxVoxels)
    throw Error(ErrorCode::kFailure, "the scene has too many voxels of this size; make them larger (-O voxel=...)");
  std::vector<VoxelKey> all;
  all.reserve(total);
  for (const auto& keys : found) all.insert(all.end(), keys.begin(), keys.end());
  sort_unique(all);
  return all;
}

/// Bakes runs of voxels. `samples` per axis and voxel.
class VoxelSampler {
public:
  VoxelSampler(const FieldSampler& field, const motion::Warp& warp, const motion::UnbornNodes& unborn,
               const VolumeOptions& options)
      : field_(field), warp_(warp), unborn_(unborn), voxel_(options.voxel),
        min_density_(static_cast<float>(-std::log(1 - options.opacity) / options.voxel)),
        per_axis_(options.voxel > 1.5 * field.field().config.cell_size() ? 2 : 1),
        world_to_canonical_(warp.rigid().inverse()) {}

  void run(std::span<const VoxelKey> keys, LayerVolume& out) const {
    const auto per_axis = static_cast<std::size_t>(per_axis_);
    const std::size_t per_voxel = per_axis * per_axis * per_axis;
    std::vector<VoxelKey> live;
    std::vector<Eigen::Vector3d> points;
    std::vector<fields::Rotation> rotations;
    for (const VoxelKey key : keys) {
      if (add_points(key, points, rotations)) live.push_back(key);
    }
    FieldSamples samples;
    field_.evaluate(points, samples);
    std::vector<std::array<float, FieldSamples::kFeatures>> features;
    for (std::size_t i = 0; i < live.size(); ++i) {
      float transmittance = 0; // mean share of light that passes
      float weight = 0;
      std::array<float, FieldSamples::kFeatures> mean{};
      for (std::size_t k = i * per_voxel; k < (i + 1) * per_voxel; ++k) {
        const float opacity = 1 - std::exp(-samples.density[k] * static_cast<float>(voxel_));
        transmittance += (1 - opacity) / static_cast<float>(per_voxel);
        weight += opacity;
        for (std::size_t f = 0; f < mean.size(); ++f) mean[f] += opacity * samples.features[k][f];
      }
      const float density = -std::log(std::max(transmittance, kBlack)) / static_cast<float>(voxel_);
      if (density < min_density_) continue;
      for (float& f : mean) f /= std::max(weight, 1e-6F);
      fields::rotate_vectors(rotations[i], mean.data());
      out.keys.push_back(live[i]);
      out.density.push_back(density);
      features.push_back(mean);
    }
    out.color = field_.colors(features);
  }

private:
  // The sample points of a voxel, in canonical space, and the layer's turn there; false if none may be occupied.
  bool add_points(VoxelKey key, std::vector<Eigen::Vector3d>& points, std::vector<fields::Rotation>& rotations) const {
    const auto voxel = voxel_of(key);
    const Eigen::Vector3d world = voxel_ * Eigen::Vector3d(voxel[0], voxel[1], voxel[2]);
    Eigen::Vector3d canonical;
    Eigen::Matrix3d to_canonical;
    if (warp_.is_rigid()) {
      canonical = world_to_canonical_ * world;
      to_canonical = world_to_canonical_.linear();
    } else {
      const auto pulled_back = warp_.to_canonical(world);
      if (!pulled_back) return false;
      if (!unborn_.empty() && motion::is_unborn(warp_.graph()->influence(*pulled_back), unborn_)) return false;
      canonical = *pulled_back;
      to_canonical = warp_.at(canonical)->linear().transpose();
    }
    const std::size_t before = points.size();
    bool any = false;
    for (int k = 0; k < per_axis_ * per_axis_ * per_axis_; ++k) {
      const Eigen::Vector3i subvoxel(k % per_axis_, k / per_axis_ % per_axis_, k / per_axis_ / per_axis_);
      const Eigen::Vector3d offset = (subvoxel.cast<double>().array() + 0.5) / per_axis_ - 0.5;
      points.emplace_back(canonical + to_canonical * (voxel_ * offset));
      any = any || field_.occupied(points.back());
    }
    if (any) {
      rotations.push_back(fields::rotation_of(to_canonical.transpose()));
    } else {
      points.resize(before);
    }
    return any;
  }

  const FieldSampler& field_;
  const motion::Warp& warp_;
  const motion::UnbornNodes& unborn_;
  double voxel_;
  float min_density_;
  int per_axis_;
  SE3 world_to_canonical_;
};

/// Both in the order of their keys.
LayerVolume merged(const LayerVolume& a, const LayerVolume& b) {
  LayerVolume out;
  const auto take = [&out](const LayerVolume& from, std::size_t i) {
    out.keys.push_back(from.keys[i]);
    out.density.push_back(from.density[i]);
    out.color.push_back(from.color[i]);
  };
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < a.keys.size() || j < b.keys.size()) {
    if (j == b.keys.size() || (i < a.keys.size() && a.keys[i] < b.keys[j])) {
      take(a, i++);
    } else if (i == a.keys.size() || b.keys[j] < a.keys[i]) {
      take(b, j++);
    } else {
      take(a, i);
      const float share = b.density[j] / (a.density[i] + b.density[j]);
      for (std::size_t c = 0; c < 3; ++c) out.color.back()[c] += share * (b.color[j][c] - a.color[i][c]);
      out.density.back() += b.density[j];
      ++i;
      ++j;
    }
  }
  return out;
}

} // namespace

VolumeBaker::VolumeBaker(const clip::Clip& clip, std::span<const std::size_t> layers, const VolumeOptions& options)
    : clip_(&clip), layers_(layers.begin(), layers.end()), options_(options) {
  if (!(options.voxel > 0) || !std::isfinite(options.voxel) || !(options.opacity > 0 && options.opacity < 1)) {
    throw Error(ErrorCode::kUsage, "a volume needs voxels larger than 0 metres");
  }
}

LayerVolume VolumeBaker::bake_layer(const clip::Layer& layer, int frame, const Progress& progress) const {
  const motion::Warp warp = layer.motion.warp(frame);
  const FieldSampler field(layer.field);
  const std::vector<VoxelKey> candidates = candidate_voxels(layer.field, warp, options_.voxel);
  const motion::UnbornNodes unborn = layer.births.unborn(frame);
  const VoxelSampler sampler(field, warp, unborn, options_);
  constexpr std::size_t kVoxels = 2048;
  std::vector<LayerVolume> baked(chunk_count(candidates.size(), kVoxels));
  parallel_for(candidates.size(), kVoxels, [&](const Chunk& chunk) {
    progress.check();
    sampler.run(std::span(candidates).subspan(chunk.begin, chunk.end - chunk.begin), baked[chunk.index]);
  });
  LayerVolume all;
  for (const LayerVolume& part : baked) {
    all.keys.insert(all.keys.end(), part.keys.begin(), part.keys.end());
    all.density.insert(all.density.end(), part.density.begin(), part.density.end());
    all.color.insert(all.color.end(), part.color.begin(), part.color.end());
  }
  return all;
}

host::Volume VolumeBaker::at(int frame, const Progress& progress) {
  LayerVolume all;
  for (const std::size_t i : layers_) {
    const clip::Layer& layer = clip_->layers[i];
    if (!clip::shown_frames(layer, clip_->times.size()).at(frame)) continue;
    if (layer.motion.kind() != motion::MotionKind::kStill) {
      all = merged(all, bake_layer(layer, frame, progress));
      continue;
    }
    if (!still_.contains(i)) still_[i] = bake_layer(layer, frame, progress);
    all = merged(all, still_[i]);
  }
  host::Volume volume;
  volume.name = "kinora";
  volume.frame = frame;
  volume.time = clip_->times[static_cast<std::size_t>(frame)];
  volume.voxel_to_world.topLeftCorner<3, 3>() *= options_.voxel;
  for (const VoxelKey key : all.keys) volume.voxels.push_back(voxel_of(key));
  volume.density = std::move(all.density);
  volume.color = std::move(all.color);
  for (auto& color : volume.color) {
    for (float& c : color) c = linear_light(c);
  }
  return volume;
}

} // namespace kinora::bake
