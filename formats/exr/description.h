// What the OpenEXR format says of itself.
#pragma once

#include <iterator>

#include "common/boundary.h"

namespace kinora::formats {

inline constexpr KinoraOption kExrOptions[] = {
    {"layout", "auto|folder|file", "auto",
     "A folder of pictures or a single one; auto: a file if the path ends in .exr.", nullptr},
    {"compression", "zip|piz|none", "zip", "Without loss: in blocks of 16 rows, by wavelets, or not at all.", nullptr}};

/// Without functions.
constexpr KinoraFormat exr_description() {
  auto format = make_struct<KinoraFormat>();
  format.name = "exr";
  format.description =
      "OpenEXR pictures: linear half RGBA with float Z, label id, normals N, confidence and the camera";
  format.extensions = ".exr";
  format.capabilities = KINORA_WRITES_PICTURES | KINORA_WRITES_ALPHA | KINORA_WRITES_METRIC_DEPTH |
                        KINORA_WRITES_NORMALS | KINORA_WRITES_CONFIDENCE | KINORA_WRITES_LABELS | KINORA_WRITES_CAMERAS;
  format.options = kExrOptions;
  format.option_count = std::size(kExrOptions);
  return format;
}

} // namespace kinora::formats
