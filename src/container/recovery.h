// What is sound of a damaged file, into a new one.
#pragma once

#include <filesystem>

#include "container/damage.h"
#include "core/progress.h"

namespace kinora::container {

struct Recovery {
  std::size_t payloads = 0;      ///< of our tracks, all of them checked
  std::size_t blocks = 0;        ///< of other tracks, whose bytes nothing can check
  std::vector<std::string> lost; ///< attachments and tracks: sentences
  DamageList damage;
  std::uint64_t file_bytes = 0;
  bool finished = false; ///< the writer of the damaged file had completed it
  bool lost_anything() const { return !damage.empty() || !lost.empty() || !finished; }
};

/// Writes tracks, undamaged attachments, chapters, tags, undamaged payloads and the blocks of other tracks of `input`
/// to `output`, which is then complete, and reads it back. Throws Error: kNotRecognised, kCorruptInput (nothing can be
/// saved, and why), kUnwritableOutput, kFailure (what was written is not what was read), kInterrupted.
Recovery recover(const std::filesystem::path& input, const std::filesystem::path& output, Progress& progress);

/// Writes all of `main`, and behind it the tracks, attachments and payloads of `other`, to `output`: what streams
/// `main` from the front never needs the rest. Kind, chapters and tags are those of `main`; names of attachments and
/// ids of tracks must differ. Throws Error: kCorruptInput if one of them is damaged, kFailure, kUnwritableOutput,
/// kInterrupted.
void append_file(const std::filesystem::path& main, const std::filesystem::path& other,
                 const std::filesystem::path& output, Progress& progress);

} // namespace kinora::container
