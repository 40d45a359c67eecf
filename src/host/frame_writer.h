// A format's writer of captures behind C++: statuses become errors; what is not finished is abandoned.
#pragma once

#include <filesystem>
#include <string>

#include "host/open_writer.h"
#include "kinora/plugin.h"

namespace kinora::host {

/// Moveable, one thread at a time. The format must outlive it. Writes exactly to the path that it is given.
class FrameWriter {
public:
  /// Throws what the plugin reports, and Error(kUsage) for options that the format does not declare or a format that
  /// writes no captures.
  FrameWriter(const KinoraFormat& format, const std::filesystem::path& path, const Options& options,
              const KinoraCaptureInfo& info);

  const KinoraFormat& format() const { return *format_; }
  /// Empty, or why the frame does not fit those before and is left out. Images that the format has no place for are
  /// dropped. Throws Error, normally kUnwritableOutput.
  std::string write(const KinoraFrame& frame);
  /// Sound: what its packets will be, before the first frame, and each before the first frame that is later. Only for
  /// formats that write it (KINORA_WRITES_SOUND).
  void set_sound(const KinoraSound& sound);
  void write_sound(const KinoraSoundPacket& packet);
  /// Completes the output. Nothing may be written afterwards.
  void finish() { finish_writer(*format_, writer_); }

private:
  const KinoraFormat* format_;
  WriterHandle writer_;
};

} // namespace kinora::host
