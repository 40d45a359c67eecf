// What the format of OpenNI's live cameras says of itself.
#pragma once

#include "common/boundary.h"

namespace kinora::formats {

inline constexpr KinoraOption kOpenNiOptions[] = {
    {"seconds", "number", "60", "How long frames come.", nullptr},
    {"focal", "number", "0", "Focal length of the colour camera in pixels; 0: as the camera says.", nullptr}};

/// Without functions.
constexpr KinoraFormat openni_description() {
  return describe("openni",
                  "live camera that OpenNI 2 knows (Xtion, Astra, Structure), as openni:0, openni:1, … or openni:URI",
                  "", KINORA_READS_FRAMES | KINORA_READS_DEVICE, kOpenNiOptions);
}

} // namespace kinora::formats
