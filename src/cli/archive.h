// encode --archive: the capture without loss, behind the clip in the same file.
#pragma once

#include <filesystem>

#include "cli/capture_input.h"

namespace kinora::cli {

/// Writes the clip of `clip_file`, and behind it all frames of the capture as kinora record has them, to `output`.
/// `audio`: a file with the capture's sound; empty: what comes with the frames. Throws what reading and writing throw.
void write_archive(const std::filesystem::path& clip_file, const std::filesystem::path& capture,
                   const CaptureReading& reading, const std::filesystem::path& audio,
                   const std::filesystem::path& output, Context& context);

} // namespace kinora::cli
