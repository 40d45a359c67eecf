// Which pictures an OpenNI recording (.oni) holds, and where they are.
// Source: the records that OpenNI 2's recorder writes, https://github.com/structureio/OpenNI2 (Source/Core/OniRecorder)
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/random_access_file.h"

namespace kinora::formats {

enum class OniPixels { kOther, kDepthMillimetres, kDepthTenthMillimetres, kRgb, kUyvy, kYuyv, kGrey, kJpeg };

struct OniPicture {
  double time = 0; ///< seconds since the stream's first picture
  std::uint64_t offset = 0;
  std::uint64_t bytes = 0;
};

struct OniStream {
  std::string codec; ///< four letters: NONE, JPEG, 16zP, 16zT
  OniPixels pixels = OniPixels::kOther;
  int width = 0; ///< without cropping
  int height = 0;
  double frames_per_second = 0;
  double horizontal_view = 0; ///< radians; 0: unknown
  double vertical_view = 0;
  bool mirrored = false; ///< right and left are changed over
  bool cropped = false;
  int crop_x = 0; ///< of the upper left corner
  int crop_y = 0;
  int crop_width = 0;
  int crop_height = 0;
  std::vector<OniPicture> pictures;
};

struct OniLog {
  std::optional<OniStream> color; ///< the first of its kind, as that of depth
  std::optional<OniStream> depth;
  std::string problem; ///< why the file is not read to its end; empty: it is
};

/// Reads the heads of all records. Throws Error: kNotRecognised.
OniLog read_oni_log(const RandomAccessFile& file);

} // namespace kinora::formats
