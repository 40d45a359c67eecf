// Pieces of clips, cut out and joined as they are stored: nothing is trained or quantised again.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "clip/clip.h"
#include "clip/clip_description.h"
#include "clip/payloads/field_codec.h"
#include "container/payload.h"
#include "container/preview.h"
#include "container/sound.h"

namespace kinora::clip {

/// Attachment name of the poster that Kinora draws.
inline constexpr const char* kPosterFile = "cover.jpg";

/// A clip as its file holds it.
struct StoredClip {
  std::string name; ///< for errors: the file's
  ClipDescription description;
  std::vector<container::Track> tracks;                              ///< the clip's own
  std::vector<container::Attachment> attachments;                    ///< the clip's own, without clip.json
  std::map<std::uint16_t, std::vector<container::Payload>> payloads; ///< by track, in the order of time
  std::optional<container::Sound> sound;
  std::optional<container::Preview> preview;
  std::optional<container::Attachment>
      poster;                               ///< a picture called cover.jpg or cover.png, as Matroska's players expect
  std::vector<container::Chapter> chapters; ///< in the order of time
  container::Tags tags;                     ///< of the whole file, but those of every Kinora file
  std::vector<std::string> others; ///< names of tracks and attachments that are not the clip's: they are left out
};

/// Throws Error as read_clip() does: everything must be there.
StoredClip load_stored_clip(const std::filesystem::path& path);

/// The same clip gives the same bytes. Throws Error(kUnwritableOutput) naming the path.
void write_stored_clip(const StoredClip& clip, const std::filesystem::path& path);

/// Frames begin to end − 1, with their times. Where the first deformation of a layer refers to earlier ones, those up
/// to the next that does not are coded again, without any change. A preview begins with its first picture from there on
/// that needs no other; the chapter that goes on at the cut begins there. Needs begin < end ≤ the number of frames.
StoredClip cut(const StoredClip& clip, std::size_t begin, std::size_t end);

/// Stores the fields of all layers again, so finely as `fields` says for each of them; `decoded` is the clip. Throws
/// Error(kFailure) if it is another.
void store_fields(const Clip& decoded, const std::vector<FieldRounding>& fields, StoredClip& clip);

/// `second` behind `first`. Its times stay as they are if they come later; else it follows a frame after the first's
/// end. Throws Error(kFailure) unless both have the same layers (fields, graphs, joints) and the same camera, as pieces
/// of one clip have. Chapters follow one another; tags and poster are the first's; a preview is kept if both have one
/// of one size.
StoredClip join(const StoredClip& first, const StoredClip& second);

} // namespace kinora::clip
