// What the format of live Kinects says of itself.
#pragma once

#include "common/boundary.h"

namespace kinora::formats {

inline constexpr KinoraOption kFreenectOptions[] = {
    {"seconds", "number", "60", "How long frames come.", nullptr},
    {"focal", "number", "525", "Focal length of the colour camera in pixels; the maker's nominal one.", nullptr}};

/// Without functions.
constexpr KinoraFormat freenect_description() {
  return describe("freenect", "live camera: the first Kinect, as freenect:0, freenect:1, …", "",
                  KINORA_READS_FRAMES | KINORA_READS_DEVICE, kFreenectOptions);
}

} // namespace kinora::formats
