// A sparse volume at one time, through a format's writer.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "host/open_writer.h"

namespace kinora::host {

/// Fog: how dense space is and what colour it has; voxels that are not listed are empty. See KinoraVolume.
struct Volume {
  std::string name;
  int frame = 0;                                                ///< of the clip
  double time = 0;                                              ///< seconds from the start
  Eigen::Matrix4d voxel_to_world = Eigen::Matrix4d::Identity(); ///< from a voxel's number (its centre) to metres
  std::vector<std::array<std::int32_t, 3>> voxels;              ///< each listed once
  std::vector<float> density;                                   ///< extinction per metre; one per voxel
  std::vector<std::array<float, 3>> color;                      ///< linear light, primaries of sRGB; one per voxel
};

/// Writes one volume to exactly this path. Throws what the plugin reports, and Error(kUsage) for options that the
/// format does not declare or a format that writes no volumes. `facts`: for the file's metadata.
void write_volume(const KinoraFormat& format, const std::filesystem::path& path, const Options& options,
                  const Volume& volume, const Facts& facts = {});

/// One file of a sequence of volumes.
struct VolumeFile {
  std::string name;                                ///< in the folder of the index
  double time = 0;                                 ///< seconds from the start, increasing
  Eigen::AlignedBox3d box = Eigen::AlignedBox3d(); ///< around its voxels, world; empty where it is not known
};

/// Writes a file that shows the volumes one after another, for formats that can. Throws what the plugin reports.
void write_volume_index(const KinoraFormat& format, const std::filesystem::path& path, const Options& options,
                        const std::vector<VolumeFile>& files, double frames_per_second, const Facts& facts);

/// The box around the volume's voxels in the world.
Eigen::AlignedBox3d box_of(const Volume& volume);

} // namespace kinora::host
