// What the reader understands of the elements at the front of a file: tracks, attachments, chapters, tags.
#pragma once

#include <functional>

#include "container/ebml.h"
#include "container/reader.h"
#include "core/error.h"

namespace kinora::container {

/// Is told of a track or attachment that cannot be read; it is left out unless this throws.
using DamagedEntry = std::function<void(const Element& entry, const Error& error)>;

/// Append to `out`. All throw Error(kCorruptInput) naming the file and the byte.
void parse_tracks(ByteSource& source, const Element& tracks, const DamagedEntry& damaged,
                  std::vector<StoredTrack>& out);
void parse_attachments(ByteSource& source, const Element& attachments, const DamagedEntry& damaged,
                       std::vector<StoredAttachment>& out);
/// The first edition's, without those that are parts of others, in the order of time.
void parse_chapters(ByteSource& source, const Element& chapters, std::vector<Chapter>& out);
/// Only tags of the whole file, not of one track, chapter or attachment.
void parse_tags(ByteSource& source, const Element& tags, Tags& out);

} // namespace kinora::container
