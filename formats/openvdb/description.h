// What the OpenVDB format says of itself.
#pragma once

#include "common/boundary.h"
#include "common/world_axes.h"

namespace kinora::formats {

inline constexpr KinoraOption kOpenVdbOptions[] = {
    {"content", "fog|surface|both", "fog",
     "Density, a level set (metres to where half of the light passes a voxel, negative inside), or both; colour with "
     "either.",
     nullptr},
    {"vdb-names", "houdini|blender|unreal", "houdini",
     "Grids called as that program looks for them: density, surface and Cd; density, distance and color; density, "
     "surface and color.",
     nullptr},
    {"precision", "half|float", "half", "16-bit numbers, half the size, or 32-bit ones.", nullptr},
    kUpOption,
    kUnitsOption};

/// Without functions.
constexpr KinoraFormat openvdb_description() {
  KinoraFormat format = describe("openvdb", "OpenVDB volume of one time: fog, a level set or both, and colour", ".vdb",
                                 KINORA_WRITES_VOLUMES | KINORA_WRITES_VOLUME_INDEX, kOpenVdbOptions);
  format.index_extension = ".usda";
  return format;
}

} // namespace kinora::formats
