#include "cli/clip_input.h"

#include <cmath>
#include <system_error>

#include <fmt/format.h>

#include "clip/missing_parts.h"
#include "core/error.h"
#include "core/frame_range.h"

namespace kinora::cli {

void require_input(const std::filesystem::path& path) {
  std::error_code ignored;
  if (std::filesystem::exists(path, ignored)) return;
  throw Error(ErrorCode::kUsage, fmt::format("{} does not exist; is the name right?", path.string()));
}

void require_clip(const std::filesystem::path& path) {
  require_input(path);
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    throw Error(ErrorCode::kNotRecognised,
                fmt::format("{} is a folder, not a clip; make a clip of a capture with kinora encode", path.string()));
  }
}

clip::Clip open_clip(const std::filesystem::path& path, Progress& progress, clip::ByteAccount* account,
                     std::vector<std::string>* missing) {
  require_clip(path);
  std::vector<std::string> parts;
  try {
    return clip::read_clip(path, account);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kCorruptInput) throw;
    clip::Clip clip = clip::read_whole_parts(std::make_unique<container::FileSource>(path), parts, account);
    if (parts.empty()) parts.emplace_back(error.what());
    progress.warn(clip::missing_sentence(path.string(), parts));
    if (missing != nullptr) *missing = std::move(parts);
    return clip;
  }
}

double frames_per_second(const clip::Clip& clip) {
  const std::size_t count = clip.times.size();
  const double duration = count > 1 ? clip.times.back() - clip.times.front() : 0;
  // Times are kept to the nanosecond: more digits of the rate than these mean nothing.
  return duration > 0 ? std::round(static_cast<double>(count - 1) / duration * 1e6) / 1e6 : 30;
}

std::vector<int> frames_in_range(const std::string& range, std::size_t count) {
  const FrameRange wanted = range.empty() ? FrameRange{} : FrameRange::parse(range);
  std::vector<int> frames = wanted.frames_of(static_cast<int>(count));
  if (frames.empty()) {
    throw Error(ErrorCode::kUsage,
                fmt::format("--frames {} names none of the {} frames, which count from 0", range, count));
  }
  return frames;
}

} // namespace kinora::cli
