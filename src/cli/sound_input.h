// Sound of a capture: what comes with its frames, or a file of its own (--audio).
#pragma once

#include <filesystem>
#include <memory>

#include <CLI/CLI.hpp>

#include "host/frame_reader.h"
#include "sound/sound_source.h"

namespace kinora::cli {

void add_audio_option(CLI::App& command, std::filesystem::path& file);

/// The sound of `file`, which begins with the capture; without a file that of the frames; null if they have none. Times
/// count from the capture's start. The reader outlives it. Throws Error: kCorruptInput, kMissingComponent.
std::unique_ptr<sound::SoundSource> open_sound_of(host::FrameReader& reader, const std::filesystem::path& file);

/// A moment on the capture's clock, from its start.
std::int64_t nanoseconds_of(double time, const KinoraCaptureInfo& info);

} // namespace kinora::cli
