// The elements at the front of a file, made from a FileHead.
#pragma once

#include <array>
#include <cstdint>

#include <ebml/EbmlHead.h>
#include <matroska/KaxAttachments.h>
#include <matroska/KaxChapters.h>
#include <matroska/KaxInfo.h>
#include <matroska/KaxTags.h>
#include <matroska/KaxTracks.h>

#include "container/writer.h"

namespace kinora::container {

/// One tick of block and cluster times. Exact times stand in the payloads; this is what remuxers use, too.
inline constexpr std::uint64_t kTimestampScaleNs = 1'000'000;

using SegmentUid = std::array<std::uint8_t, 16>;

void fill_ebml_head(libebml::EbmlHead& head);
/// Always of the same length, so that it can be written again over itself.
void fill_info(libmatroska::KaxInfo& info, const SegmentUid& uid, std::int64_t duration_ns);
/// Matroska's track number is the place in head.tracks + 1.
void fill_tracks(libmatroska::KaxTracks& tracks, const FileHead& head);
void fill_attachments(libmatroska::KaxAttachments& attachments, const FileHead& head);
void fill_chapters(libmatroska::KaxChapters& chapters, const FileHead& head);
void fill_tags(libmatroska::KaxTags& tags, const FileHead& head);

} // namespace kinora::container
