// A folder of OpenEXR files as a capture: what ExrSequenceWriter writes, and what renderers do.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/calibration.h"
#include "common/capture_info.h"
#include "common/label_file.h"
#include "exr/exr_frame.h"

namespace kinora::formats {

/// Frames are in the order of the numbers in their names, or of their times if every file says its own; else they
/// follow one another at the nominal rate. intrinsics.json of the folder goes before what the files say. Not
/// thread-safe. Images of a frame stay valid until the next call.
class ExrSequenceReader {
public:
  /// Reads all headers. Throws Error: kNotRecognised without .exr files, kCorruptInput if none can be read or nothing
  /// says where the camera's focal length is.
  ExrSequenceReader(const std::filesystem::path& folder, bool read_masks);

  void fill_info(KinoraCaptureInfo& info) const;
  /// KINORA_OK or KINORA_END. Throws Error(kCorruptInput) for a bad frame, after which the next one can be read.
  KinoraStatus next(KinoraFrame& frame);
  /// Throws Error(kUsage) outside of 0 … frame count.
  void seek(std::int64_t index);

private:
  struct File {
    std::filesystem::path path;
    ExrHead head;
    std::string problem; ///< why it cannot be used; empty if it can
    double time = 0;
  };

  const ExrHead& first_head() const;
  void settle_camera(const std::filesystem::path& folder);
  void settle_times(const std::filesystem::path& folder);

  bool read_masks_;
  bool has_masks_ = false;
  std::vector<File> files_;
  Calibration calibration_;
  double frames_per_second_ = 30;
  bool has_poses_ = false;
  LabelTable labels_;
  std::vector<std::string> warnings_;
  WarningTable warning_table_;
  std::size_t next_ = 0;
  ExrFrame frame_;
};

} // namespace kinora::formats
