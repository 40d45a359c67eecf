// What the MP4 format says of itself.
#pragma once

#include <iterator>

#include "common/boundary.h"

namespace kinora::formats {

inline constexpr KinoraOption kMp4Options[] = {
    {"fps", "number", "30", "Nominal frames per second; the pictures' own times decide when each is shown.", nullptr},
    {"crf", "int", "18", "Quality from 0 (largest file) to 51 (smallest).", nullptr},
};

/// Without functions.
constexpr KinoraFormat mp4_description() {
  auto format = make_struct<KinoraFormat>();
  format.name = "mp4";
  format.description = "film: MP4 with H.264, or MPEG-4 part 2 where no H.264 encoder is installed; WebM with VP9";
  format.extensions = ".mp4 .webm";
  format.capabilities = KINORA_WRITES_PICTURES | KINORA_WRITES_FILM;
  format.options = kMp4Options;
  format.option_count = std::size(kMp4Options);
  return format;
}

} // namespace kinora::formats
