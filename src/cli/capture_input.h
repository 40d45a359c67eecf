// How a command reads a capture: --format and -O.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "cli/context.h"
#include "host/frame_reader.h"

namespace kinora::cli {

struct CaptureReading {
  std::string format;               ///< empty: whoever recognises the capture best
  std::vector<std::string> options; ///< of that format: "name=value"
};

/// --format and -O, for commands that read captures.
void add_reading_options(CLI::App& command, CaptureReading& reading);

/// Throws Error(kUsage) if there is nothing at `capture` and it is no live camera.
void require_capture(const std::filesystem::path& capture, Context& context);

/// Opens the capture frame by frame. Throws what the format reports, and Error(kUsage) for an option that it has not.
host::FrameReader open_frames(const std::filesystem::path& capture, const CaptureReading& reading, Context& context);

} // namespace kinora::cli
