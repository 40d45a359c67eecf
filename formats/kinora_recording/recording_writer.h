// Frames of a capture into a recording, through the plugin interface.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "record/recorder.h"

namespace kinora::formats {

/// Not thread-safe. The file is made with the first frame.
class RecordingWriter {
public:
  explicit RecordingWriter(std::filesystem::path path) : path_(std::move(path)) {}

  void set_capture(const KinoraCaptureInfo& info) { description_ = recording::description_of(info, ""); }
  /// Empty, or why the frame is left out. Throws what Recorder throws.
  std::string write(const KinoraFrame& frame);
  /// Throws Error(kFailure) without a frame, and what Recorder throws.
  void finish();

private:
  std::filesystem::path path_;
  recording::Description description_;
  std::optional<record::Recorder> recorder_;
};

} // namespace kinora::formats
