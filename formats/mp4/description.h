// What the MP4 format says of itself.
#pragma once

#include "common/boundary.h"

namespace kinora::formats {

inline constexpr KinoraOption kMp4Options[] = {
    {"fps", "number", "30", "Nominal frames per second; the pictures' own times decide when each is shown.", nullptr},
    {"crf", "int", "18", "Quality from 0 (largest file) to 51 (smallest).", nullptr},
    {"jump", "number", "0", "Seconds between pictures that players can jump to; 0: as the encoder likes.", nullptr},
};

/// Without functions.
constexpr KinoraFormat mp4_description() {
  return describe("mp4", "film: MP4 with H.264, or MPEG-4 part 2 where no H.264 encoder is installed; WebM with VP9",
                  ".mp4 .webm", KINORA_WRITES_PICTURES | KINORA_WRITES_FILM, kMp4Options);
}

} // namespace kinora::formats
