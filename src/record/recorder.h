// Frames of a capture into a recording, without loss.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>

#include "container/sound.h"
#include "container/writer.h"
#include "kinora/plugin.h"
#include "recording/layout.h"
#include "recording/lossless_video.h"

namespace kinora::record {

/// How a frame came from a device.
struct Arrival {
  std::uint32_t dropped_before = 0;         ///< frames that the device lost
  std::optional<std::int64_t> host_time_ns; ///< since 1970; nothing: it came from a file
};

/// Colour keeps its own bytes if the first frame's was decoded from JPEG, else it is FFV1, as all other pictures. The
/// same frames give the same bytes. Not thread-safe. Throws Error: kUnwritableOutput (then finish_at_last_cluster
/// completes the file), kFailure, kMissingComponent.
class Recorder {
public:
  /// Creates or replaces the file. `first` is a frame without a problem: it says which pictures there are (labels: the
  /// description does). `sound`: what its packets will be; null if there are none.
  Recorder(const std::filesystem::path& path, const recording::Description& description, const KinoraFrame& first,
           const container::Track* sound = nullptr);

  /// Writes a frame. False, and nothing is written but why, if it does not fit the recording: its colour is not JPEG
  /// though the first one's was, or a picture has another size.
  bool write(const KinoraFrame& frame, const Arrival& arrival = {});
  /// Writes that the source could not give a frame.
  void write_problem(std::int64_t index, double time, const std::string& problem, const Arrival& arrival = {});
  /// Writes a packet of sound, its time from the description's start; what is earlier is left out. It counts with the
  /// frame that is written next.
  void write_sound(const container::Payload& packet);
  void finish() { writer_->finish(); }
  void finish_at_last_cluster() { writer_->finish_at_last_cluster(); }

private:
  struct Picture {
    recording::Stream stream;
    const KinoraImage* image;
    container::Bytes bytes;
  };

  container::Track track_of(recording::Stream stream, bool jpeg);
  std::string misfit(const KinoraFrame& frame) const;
  void encode(Picture& picture, const KinoraFrame& frame);
  std::int64_t block_time(double time);
  void write_record(recording::FrameRecord& record, std::int64_t time_ns);

  recording::Description description_;
  bool jpeg_;
  std::map<recording::Stream, std::unique_ptr<recording::LosslessEncoder>> encoders_;
  std::unique_ptr<container::Writer> writer_;
  std::int64_t last_time_ns_ = 0;
  std::vector<std::uint32_t> sound_; ///< checksums of the packets since the last frame
};

} // namespace kinora::record
