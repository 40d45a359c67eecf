// Frames of a recording in the plugin interface's form, bit by bit as they were recorded.
#pragma once

#include <filesystem>

#include "common/capture_info.h"
#include "core/image.h"
#include "kinora/plugin.h"
#include "recording/recording_file.h"

namespace kinora::formats {

/// Not thread-safe. Images of a frame stay valid until the next call.
class RecordingReader {
public:
  /// Throws Error: kNotRecognised, kCorruptInput.
  RecordingReader(const std::filesystem::path& path, bool read_masks);

  void fill_info(KinoraCaptureInfo& info) const;
  /// KINORA_OK or KINORA_END. Throws Error(kCorruptInput) for a bad frame, after which the next one can be read.
  KinoraStatus next(KinoraFrame& frame);
  /// Throws Error(kUsage) outside of 0 … frame count.
  void seek(std::int64_t index);
  bool fill_sound(KinoraSound& sound) const;
  /// Damaged packets are passed over.
  bool next_sound(KinoraSoundPacket& packet);

private:
  void put_in_order();
  KinoraImage read(std::size_t index, recording::Stream stream);
  KinoraImage read_color(std::size_t index, KinoraFrame& frame);

  std::string name_;
  bool read_masks_;
  recording::RecordingFile file_;
  std::vector<std::size_t> order_; ///< numbers of the file's frames, in order of time
  std::vector<KinoraLabel> labels_;
  std::vector<std::string> warnings_;
  WarningTable warning_table_;
  std::size_t next_ = 0;
  std::size_t next_sound_ = 0;
  container::Payload sound_packet_;
  ColorImage color_;
  container::Bytes encoded_color_;
  std::array<std::vector<std::byte>, recording::kStreams> pixels_;
};

} // namespace kinora::formats
