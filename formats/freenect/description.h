// What the format of live Kinects says of itself.
#pragma once

#include <iterator>

#include "common/boundary.h"

namespace kinora::formats {

inline constexpr KinoraOption kFreenectOptions[] = {
    {"seconds", "number", "60", "How long frames come.", nullptr},
    {"focal", "number", "525", "Focal length of the colour camera in pixels; the maker's nominal one.", nullptr}};

/// Without functions.
constexpr KinoraFormat freenect_description() {
  auto format = make_struct<KinoraFormat>();
  format.name = "freenect";
  format.description = "live camera: the first Kinect, as freenect:0, freenect:1, …";
  format.extensions = "";
  format.capabilities = KINORA_READS_FRAMES | KINORA_READS_DEVICE;
  format.options = kFreenectOptions;
  format.option_count = std::size(kFreenectOptions);
  return format;
}

} // namespace kinora::formats
