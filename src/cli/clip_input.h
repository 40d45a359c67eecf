// Opening what the command line names as input.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "clip/clip.h"
#include "clip/clip_io.h"
#include "core/progress.h"

namespace kinora::cli {

/// Throws Error(kUsage) if there is nothing at `path`.
void require_input(const std::filesystem::path& path);

/// Throws Error(kUsage) if there is nothing at `path`, Error(kNotRecognised) if that is a folder.
void require_clip(const std::filesystem::path& path);

/// Reads a clip; an input that is no file of ours is told apart from one that is a capture. Of a damaged one, what is
/// whole, after one warning that says what is missing; `missing` gets that, too (clip::read_whole_parts).
clip::Clip open_clip(const std::filesystem::path& path, Progress& progress, clip::ByteAccount* account = nullptr,
                     std::vector<std::string>* missing = nullptr);

/// Frames per second of a clip, from its times (30 if it has one frame).
double frames_per_second(const clip::Clip& clip);

/// The frame numbers of a range that a clip of `count` frames has. Throws Error(kUsage) if there are none.
std::vector<int> frames_in_range(const std::string& range, std::size_t count);

} // namespace kinora::cli
