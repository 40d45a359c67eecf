// A format's reader behind C++: statuses become errors, memory is freed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "core/error.h"
#include "host/options.h"
#include "host/simulated_device.h"
#include "kinora/plugin.h"

namespace kinora::host {

/// One frame, or why there is none.
struct ReadFrame {
  KinoraFrame frame;   ///< its images are valid until the next call for the reader; only `index` if there is a problem
  std::string problem; ///< why this frame cannot be used; empty if it can
  std::uint32_t dropped_before = 0; ///< frames between the one before and this one that a device lost
};

/// Moveable, one thread at a time. The format must outlive it.
class FrameReader {
public:
  /// Throws what the plugin reports, Error(kFailure) if it breaks the interface (no reader, a list that is missing),
  /// and Error(kUsage) for options that the format does not declare or a format that does not read.
  FrameReader(const KinoraFormat& format, const std::filesystem::path& path, const Options& options);

  const KinoraFormat& format() const { return *format_; }
  /// Valid as long as the reader.
  const KinoraCaptureInfo& info() const { return info_; }
  /// The next frame; nothing at the end. What is not as the plugin's own description says has a problem. Throws Error
  /// when reading cannot go on.
  std::optional<ReadFrame> next();
  /// The next frame will be that with this index; reads and drops frames where the format cannot seek. Going back then
  /// throws Error(kFailure).
  void seek(std::int64_t index);
  /// Index of the frame that comes next.
  std::int64_t position() const { return position_; }
  /// What the packets of the capture's sound are; nothing if it has none. Valid as long as the reader.
  std::optional<KinoraSound> sound();
  /// The next packet of sound, from the beginning on, whichever frames were read; valid until the next call. Nothing at
  /// the end. Throws Error when it cannot be read any further.
  std::optional<KinoraSoundPacket> next_sound();
  /// From now on frames come as this device gives them, and end with it.
  void replay(std::shared_ptr<SimulatedDevice> device) { device_ = std::move(device); }

private:
  std::optional<ReadFrame> read_next();
  std::uint32_t pass_over_lost();
  const KinoraFormat* format_;
  std::unique_ptr<KinoraReader, void (*)(KinoraReader*)> reader_;
  KinoraCaptureInfo info_;
  std::int64_t position_ = 0;
  std::shared_ptr<SimulatedDevice> device_; ///< null: frames are there at once
  std::optional<double> last_time_;         ///< of the last frame that the device had
};

} // namespace kinora::host
