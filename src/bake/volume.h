// A clip at one frame as a sparse volume in the world: density and colour on a regular grid.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "clip/clip.h"
#include "core/progress.h"
#include "host/volume_writer.h"

namespace kinora::bake {

struct VolumeOptions {
  double voxel = 0.01;   ///< side of a voxel, metres
  double opacity = 0.01; ///< voxels that are less opaque across than this are left out
};

/// Voxels of one layer, in the order of their keys; `color` is sRGB.
struct LayerVolume {
  std::vector<std::uint64_t> keys;
  std::vector<float> density;
  std::vector<std::array<float, 3>> color;
};

/// Keeps references to the clip. Still layers are baked once. Not thread-safe; uses all threads; same bits for any
/// number of them.
class VolumeBaker {
public:
  /// `layers`: numbers of the layers to bake. Throws Error(kUsage) for options that make no sense.
  VolumeBaker(const clip::Clip& clip, std::span<const std::size_t> layers, const VolumeOptions& options);

  /// Every voxel near an occupied cell of a layer is pulled back into the layer's canonical space by the warp of the
  /// frame, and takes the density by which as much light passes as does on average at a few points inside
  /// it (at least 1e-4). Where layers meet, densities add up and colours
  /// mix. A layer is not there before its first frame. Throws Error: kFailure if the scene is too large for voxels so
  /// small, kInterrupted.
  host::Volume at(int frame, const Progress& progress);

private:
  LayerVolume bake_layer(const clip::Layer& layer, int frame, const Progress& progress) const;

  const clip::Clip* clip_;
  std::vector<std::size_t> layers_;
  VolumeOptions options_;
  std::map<std::size_t, LayerVolume> still_;
};

} // namespace kinora::bake
