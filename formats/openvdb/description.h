// What the OpenVDB format says of itself.
#pragma once

#include <iterator>

#include "common/boundary.h"

namespace kinora::formats {

inline constexpr KinoraOption kOpenVdbOptions[] = {
    {"precision", "half|float", "half", "16-bit numbers, half the size, or 32-bit ones.", nullptr}};

/// Without functions.
constexpr KinoraFormat openvdb_description() {
  auto format = make_struct<KinoraFormat>();
  format.name = "openvdb";
  format.description = "OpenVDB fog volume of one time: grids density and Cd";
  format.extensions = ".vdb";
  format.capabilities = KINORA_WRITES_VOLUMES;
  format.options = kOpenVdbOptions;
  format.option_count = std::size(kOpenVdbOptions);
  return format;
}

} // namespace kinora::formats
