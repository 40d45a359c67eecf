// Captures as OpenEXR files, one for each frame.
#pragma once

#include <filesystem>
#include <string>

#include "common/label_file.h"
#include "exr/exr_picture.h"

namespace kinora::formats {

/// Writes NNNNNN.exr, intrinsics.json and, where labels mean something, labels.json. Channels and attributes are those
/// of ExrWriter's pictures: R G B A (half; colour of 8 bits comes back as it was), Z (float metres; units of depth come
/// back as they were), and, as far as the frame has them, id, confidence and infrared (unsigned, 16 bits of it used).
/// Besides, "depth_unit" is metres per unit of the depth that Z was made of, "time" is the frame's own, and
/// "camera_to_world" the pose in double, in Kinora's axes, row by row as plugin.h has matrices. Not thread-safe.
class ExrSequenceWriter {
public:
  /// `folder` is there and empty.
  ExrSequenceWriter(std::filesystem::path folder, ExrCompression compression)
      : folder_(std::move(folder)), compression_(compression) {}

  void set_capture(const KinoraCaptureInfo& info);
  /// Empty, or why the frame is left out. Throws Error: kUnwritableOutput, kUsage.
  std::string write(const KinoraFrame& frame);
  /// Throws Error: kUnwritableOutput, kFailure without a frame.
  void finish() const;

private:
  std::filesystem::path folder_;
  ExrCompression compression_;
  KinoraCamera camera_{};
  double frames_per_second_ = 30;
  double depth_unit_ = 0.001; ///< of the first frame
  LabelTable labels_;
  std::size_t written_ = 0;
};

} // namespace kinora::formats
