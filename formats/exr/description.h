// What the OpenEXR formats say of themselves.
#pragma once

#include "common/boundary.h"

namespace kinora::formats {

inline constexpr KinoraOption kExrOptions[] = {
    {"layout", "auto|folder|file", "auto",
     "A folder of pictures or a single one; auto: a file if the path ends in .exr.", nullptr},
    {"compression", "zip|piz|none", "zip", "Without loss: in blocks of 16 rows, by wavelets, or not at all.", nullptr},
    {"views", "files|parts", "files",
     "A file for each picture of a folder, or one for each time, with the views as parts that have their names.",
     nullptr}};

/// Without functions.
constexpr KinoraFormat exr_description() {
  return describe(
      "exr", "OpenEXR pictures: linear half RGBA with float Z, label id, normals N, confidence and the camera", ".exr",
      KINORA_WRITES_PICTURES | KINORA_WRITES_ALPHA | KINORA_WRITES_METRIC_DEPTH | KINORA_WRITES_NORMALS |
          KINORA_WRITES_CONFIDENCE | KINORA_WRITES_LABELS | KINORA_WRITES_CAMERAS | KINORA_WRITES_PICTURE_LAYERS,
      kExrOptions);
}

inline constexpr KinoraOption kExrSequenceOptions[] = {
    {"compression", "piz|zip|none", "piz", "Without loss: by wavelets, in blocks of 16 rows, or not at all.", nullptr},
    {"masks", "bool", "true", "Read the labels of the channel id where there is one.", nullptr}};

/// Without functions but those that are given.
constexpr KinoraFormat exr_sequence_description() {
  return describe("exr-sequence", "folder of OpenEXR files with colour and depth (R G B Z), one for each frame", "",
                  KINORA_READS_FRAMES | KINORA_SEEKS | KINORA_READS_POSES | KINORA_READS_MASKS |
                      KINORA_READS_CONFIDENCE | KINORA_READS_INFRARED | KINORA_WRITES_FRAMES | KINORA_WRITES_TIMES |
                      KINORA_WRITES_POSES | KINORA_WRITES_MASKS | KINORA_WRITES_INFRARED | KINORA_WRITES_CONFIDENCE,
                  kExrSequenceOptions);
}

} // namespace kinora::formats
