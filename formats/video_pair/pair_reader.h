// A folder with a video of colour and a video of depth, registered to each other.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/calibration.h"
#include "common/capture_info.h"
#include "common/frame_pairs.h"
#include "common/video_file.h"
#include "sound/sound_source.h"
#include "video_pair/hue_depth.h"

namespace kinora::formats {

/// The two files of a folder, or nothing: one video whose name has "depth" in it, and one whose name has not.
struct VideoPair {
  std::filesystem::path color;
  std::filesystem::path depth;
};
std::optional<VideoPair> find_video_pair(const std::filesystem::path& folder);

/// Not thread-safe. Images of a frame stay valid until the next call.
class PairReader {
public:
  /// Throws Error: kNotRecognised, kCorruptInput, kMissingComponent.
  PairReader(const std::filesystem::path& folder, const HueRange& hue);

  void fill_info(KinoraCaptureInfo& info) const;
  /// KINORA_OK or KINORA_END. Throws Error(kCorruptInput) for a bad frame, after which the next one can be read.
  KinoraStatus next(KinoraFrame& frame);
  /// Throws Error(kUsage) outside of 0 … frame count.
  void seek(std::int64_t index);
  /// Sound is that of the video of colour.
  bool fill_sound(KinoraSound& sound);
  bool next_sound(KinoraSoundPacket& packet);

private:
  VideoPair files_;
  HueRange hue_;
  Calibration calibration_;
  VideoStream color_stream_;
  VideoStream depth_stream_;
  std::unique_ptr<VideoReader> color_video_;
  std::unique_ptr<VideoReader> depth_video_;
  std::vector<FramePair> frames_;
  std::vector<std::string> warnings_;
  WarningTable warning_table_;
  std::size_t next_ = 0;
  ColorImage color_;
  std::vector<std::byte> jpeg_;
  DepthImage16 depth_;
  std::unique_ptr<sound::SoundSource> sound_;
  container::Payload sound_packet_;
};

} // namespace kinora::formats
