// What the reader understands of the elements at the front of a file: tracks, attachments, tags.
#pragma once

#include "container/ebml.h"
#include "container/reader.h"

namespace kinora::container {

/// Appends to `out`. All throw Error(kCorruptInput) naming the file and the byte.
void parse_tracks(ByteSource& source, const Element& tracks, std::vector<StoredTrack>& out);
void parse_attachments(ByteSource& source, const Element& attachments, std::vector<StoredAttachment>& out);
/// Only tags of the whole file, not of one track, chapter or attachment.
void parse_tags(ByteSource& source, const Element& tags, Tags& out);

} // namespace kinora::container
