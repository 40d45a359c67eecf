// Frames of a capture into a recording, through the plugin interface.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "record/recorder.h"
#include "sound/plugin_sound.h"

namespace kinora::formats {

/// Not thread-safe. The file is made with the first frame.
class RecordingWriter {
public:
  explicit RecordingWriter(std::filesystem::path path) : path_(std::move(path)) {}

  void set_capture(const KinoraCaptureInfo& info) { description_ = recording::description_of(info, ""); }
  void set_sound(const KinoraSound& sound) { sound_ = sound::track_of(sound); }
  /// Before the first frame, it waits for that.
  void write_sound(const KinoraSoundPacket& packet);
  /// Empty, or why the frame is left out. Throws what Recorder throws.
  std::string write(const KinoraFrame& frame);
  /// Throws Error(kFailure) without a frame, and what Recorder throws.
  void finish();

private:
  std::filesystem::path path_;
  recording::Description description_;
  std::optional<container::Track> sound_;
  std::vector<container::Payload> early_sound_;
  std::optional<record::Recorder> recorder_;
};

} // namespace kinora::formats
