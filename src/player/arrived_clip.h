// A clip whose file has come up to some byte: over a network, or while it is still being written.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "clip/clip.h"

namespace kinora::player {

/// What can be shown of it: layers of which a field has come, as fine as it has come, and frames whose motion has come.
struct ArrivedClip {
  std::optional<clip::Clip> clip; ///< nothing: more has to come before anything can be shown
  std::string missing;            ///< one sentence; empty: nothing is missing
  std::size_t layers = 0;         ///< that the file says it has
  std::vector<double> times;      ///< of all frames that the file says it has, seconds; those of `clip` are the first
  std::vector<bool> there;        ///< whether each of them has come; none behind those of `clip`

  bool has_all_layers() const { return clip && clip->layers.size() == layers; }
};

/// `bytes`: the file from its first byte on, or pieces of it one behind the other, of which each but the first begins
/// with a cluster; `last`: nothing will follow them. Safe for untrusted input. Throws Error:
/// kNotRecognised as soon as that is known; what read_whole_parts throws if the last bytes have come.
ArrivedClip read_arrived(std::span<const std::byte> bytes, const std::string& name, bool last);

enum class FileState {
  kFinished, ///< its writer says so; or it is no file of ours, of which nothing will come
  kGrowing,  ///< its writer has not finished it
  kCut       ///< it was finished, and is not all here
};

/// What a file's bytes say of it.
FileState state_of(std::span<const std::byte> bytes, const std::string& name);

} // namespace kinora::player
