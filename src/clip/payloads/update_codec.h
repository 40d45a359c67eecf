// The parts of a S_KINORA/UPDATE payload: a clip as it is while it grows, whole or as what changed since.
// docs/container.md specifies them.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "clip/coding/zstd_codec.h"

namespace kinora::clip {

/// What a part holds.
enum class UpdatePart : std::uint16_t {
  kDescription, ///< clip.json, compressed
  kMetadata,    ///< metadata.json, compressed
  kField,
  kGraph,
  kMotion, ///< frames of a layer or of the camera
  kConfidence,
  kJoints,
  kBirths
};

struct PartView {
  UpdatePart what = UpdatePart::kDescription;
  std::uint16_t track = 0; ///< that clip.json names; 0 for those of the whole clip
  std::uint32_t from_key =
      0; ///< of a motion: frames that are as in the key update; of a field: 1 for a difference to its
  std::span<const std::byte> bytes;
};

struct UpdateView {
  std::uint32_t key = 0; ///< number of the key update that it is understood with; of a key update its own
  std::vector<PartView> parts;
};

Bytes encode_update(const UpdateView& update);

/// Views of `payload`. Parts of kinds that this Kinora does not know are left out. Safe for untrusted input.
/// Throws Error(kCorruptInput) naming `location`.
UpdateView decode_update(std::span<const std::byte> payload, const std::string& location);

/// Coded frames of a motion in one part. A frame may be a key payload of its track.
struct FrameView {
  bool key = true;
  std::span<const std::byte> bytes;
};
void append_frame(Bytes& part, const FrameView& frame);
/// Throws as above.
std::vector<FrameView> frames_of(std::span<const std::byte> part, const std::string& location);

} // namespace kinora::clip
