// OpenNI's recordings (.oni), read without its library: that one's player gives nothing of a recording that does not
// say how it was cropped, and crashes when it is to go to a frame.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/capture_info.h"
#include "openni/oni_log.h"

namespace kinora::formats {

/// Colour and depth are paired within 20 ms. Pictures that were recorded with right and left changed over are turned.
/// Not thread-safe. Images of a frame stay valid until the next call.
class OniReader {
public:
  /// `focal_length` of colour in pixels; 0: as the file says. Throws Error: kNotRecognised, kCorruptInput.
  OniReader(const std::filesystem::path& path, double focal_length);

  void fill_info(KinoraCaptureInfo& info) const;
  /// KINORA_OK or KINORA_END. Throws Error(kCorruptInput) for a bad frame, after which the next one can be read.
  KinoraStatus next(KinoraFrame& frame);
  /// Throws Error(kUsage) outside of 0 … frame count.
  void seek(std::int64_t index);

private:
  struct Frame {
    double time;
    OniPicture color;
    OniPicture depth;
  };

  Intrinsics camera_of_stream(const OniStream& stream, double focal_length) const;
  void pair_pictures();
  void read_color(const OniPicture& picture, KinoraFrame& frame);

  RandomAccessFile file_;
  OniStream color_stream_;
  OniStream depth_stream_;
  Intrinsics color_camera_;
  Intrinsics depth_camera_;
  std::vector<std::string> warnings_;
  WarningTable warning_table_;
  std::vector<Frame> frames_;
  double frames_per_second_ = 30;
  std::size_t next_ = 0;
  std::vector<std::byte> color_bytes_;
  ColorImage color_;
  DepthImage16 depth_;
};

} // namespace kinora::formats
