#include "container/matroska_head.h"

#include <ebml/EbmlSubHead.h>
#include <matroska/KaxAttached.h>
#include <matroska/KaxInfoData.h>
#include <matroska/KaxTag.h>
#include <matroska/KaxTrackAudio.h>
#include <matroska/KaxTrackEntryData.h>
#include <matroska/KaxTrackVideo.h>

#include "container/crc32c.h"
#include "container/envelope.h"
#include "container/valid_utf8.h"
#include "core/random.h"

namespace kinora::container {

using namespace libebml;
using namespace libmatroska;

namespace {

constexpr const char* kApplication = "Kinora";
// A subtitle: the type under which remuxers keep tracks whose codec they do not know.
constexpr std::uint64_t kSubtitle = 0x11;
constexpr std::uint64_t kVideo = 1;
constexpr std::uint64_t kSound = 2;
constexpr const char* kOpusCodec = "A_OPUS";
constexpr std::uint64_t kOpusPreRollNs = 80'000'000; // RFC 7845, section 4.6

template <class Child> void set_uint(EbmlMaster& parent, std::uint64_t value) {
  static_cast<EbmlUInteger&>(GetChild<Child>(parent)).SetValue(value);
}
template <class Child> void set_text(EbmlMaster& parent, const std::string& value) {
  static_cast<EbmlString&>(GetChild<Child>(parent)).SetValue(value);
}
template <class Child> void set_utf8(EbmlMaster& parent, const std::string& value) {
  static_cast<EbmlUnicodeString&>(GetChild<Child>(parent)).SetValueUTF8(valid_utf8(value));
}
template <class Child> void set_bytes(EbmlMaster& parent, std::span<const std::byte> bytes) {
  GetChild<Child>(parent).CopyBuffer(reinterpret_cast<const binary*>(bytes.data()),
                                     static_cast<std::uint32_t>(bytes.size()));
}

// Matroska's UIDs: never zero, the same for the same contents.
std::uint64_t uid_of(const std::string& text, std::span<const std::byte> bytes, std::uint64_t salt) {
  const std::uint64_t text_crc = crc32c(std::as_bytes(std::span(text)));
  return mix64(salt ^ mix64(text_crc << 32 | crc32c(bytes))) | 1;
}

std::uint64_t type_of(const Track& track) {
  if (!track.media) return kSubtitle;
  return track.media->width > 0 ? kVideo : kSound;
}

void fill_media(KaxTrackEntry& entry, const MediaFormat& media) {
  if (media.duration_ns > 0) {
    set_uint<KaxTrackDefaultDuration>(entry, static_cast<std::uint64_t>(media.duration_ns));
  }
  if (media.width > 0) {
    auto& video = GetChild<KaxTrackVideo>(entry);
    set_uint<KaxVideoPixelWidth>(video, static_cast<std::uint64_t>(media.width));
    set_uint<KaxVideoPixelHeight>(video, static_cast<std::uint64_t>(media.height));
    return;
  }
  if (media.delay_ns > 0) set_uint<KaxCodecDelay>(entry, static_cast<std::uint64_t>(media.delay_ns));
  auto& audio = GetChild<KaxTrackAudio>(entry);
  static_cast<EbmlFloat&>(GetChild<KaxAudioSamplingFreq>(audio)).SetValue(media.sampling_rate);
  set_uint<KaxAudioChannels>(audio, static_cast<std::uint64_t>(media.channels));
  if (media.bits > 0) set_uint<KaxAudioBitDepth>(audio, static_cast<std::uint64_t>(media.bits));
}

void add_tag(KaxTag& tag, const std::string& name, const std::string& value) {
  auto& simple = AddNewChild<KaxTagSimple>(tag);
  set_utf8<KaxTagName>(simple, name);
  set_utf8<KaxTagString>(simple, value);
}

} // namespace

void fill_ebml_head(EbmlHead& head) {
  constexpr std::uint64_t kMatroskaVersion = 4;
  constexpr std::uint64_t kReadVersion = 2; // SimpleBlock
  set_text<EDocType>(head, "matroska");
  set_uint<EDocTypeVersion>(head, kMatroskaVersion);
  set_uint<EDocTypeReadVersion>(head, kReadVersion);
}

void fill_info(KaxInfo& info, const SegmentUid& uid, std::int64_t duration_ns) {
  set_uint<KaxTimecodeScale>(info, kTimestampScaleNs);
  set_utf8<KaxMuxingApp>(info, kApplication);
  set_utf8<KaxWritingApp>(info, kApplication);
  GetChild<KaxSegmentUID>(info).CopyBuffer(uid.data(), static_cast<std::uint32_t>(uid.size()));
  auto& duration = static_cast<EbmlFloat&>(GetChild<KaxDuration>(info));
  duration.SetPrecision(EbmlFloat::FLOAT_64);
  duration.SetValue(static_cast<double>(duration_ns) / static_cast<double>(kTimestampScaleNs));
}

void fill_tracks(KaxTracks& tracks, const FileHead& head) {
  std::uint64_t number = 0;
  for (const Track& track : head.tracks) {
    auto& entry = AddNewChild<KaxTrackEntry>(tracks);
    set_uint<KaxTrackNumber>(entry, ++number);
    set_uint<KaxTrackUID>(entry, uid_of(track.codec + track.name, track.private_data, track.id));
    set_uint<KaxTrackType>(entry, type_of(track));
    set_uint<KaxTrackFlagDefault>(entry, 0);
    set_uint<KaxTrackFlagLacing>(entry, 0);
    set_text<KaxTrackLanguage>(entry, "und");
    set_utf8<KaxTrackName>(entry, track.name);
    set_text<KaxCodecID>(entry, track.codec);
    if (!track.media) set_bytes<KaxCodecPrivate>(entry, wrap_private(track));
    if (track.media && !track.private_data.empty()) set_bytes<KaxCodecPrivate>(entry, track.private_data);
    if (track.media) fill_media(entry, *track.media);
    if (track.codec == kOpusCodec) set_uint<KaxSeekPreRoll>(entry, kOpusPreRollNs);
    entry.SetGlobalTimecodeScale(kTimestampScaleNs);
  }
}

void fill_attachments(KaxAttachments& attachments, const FileHead& head) {
  for (const Attachment& attachment : head.attachments) {
    auto& file = AddNewChild<KaxAttached>(attachments);
    set_utf8<KaxFileDescription>(file, with_checksum(attachment.description, attachment.bytes));
    set_utf8<KaxFileName>(file, attachment.name);
    set_text<KaxMimeType>(file, attachment.media_type);
    set_uint<KaxFileUID>(file, uid_of(attachment.name, attachment.bytes, 0));
    set_bytes<KaxFileData>(file, attachment.bytes);
  }
}

void fill_chapters(KaxChapters& chapters, const FileHead& head) {
  auto& edition = AddNewChild<KaxEditionEntry>(chapters);
  set_uint<KaxEditionFlagDefault>(edition, 1);
  std::uint64_t number = 0;
  for (const Chapter& chapter : head.chapters) {
    auto& atom = AddNewChild<KaxChapterAtom>(edition);
    set_uint<KaxChapterUID>(atom, uid_of(chapter.title, {}, ++number));
    set_uint<KaxChapterTimeStart>(atom, static_cast<std::uint64_t>(chapter.time_ns));
    auto& display = GetChild<KaxChapterDisplay>(atom);
    set_utf8<KaxChapterString>(display, chapter.title);
    set_text<KaxChapterLanguage>(display, "und");
  }
}

void fill_tags(KaxTags& tags, const FileHead& head) {
  auto& tag = AddNewChild<KaxTag>(tags);
  GetChild<KaxTagTargets>(tag);
  add_tag(tag, kKindTag, head.kind);
  add_tag(tag, kVersionTag, std::to_string(kFileVersion));
  for (const auto& [name, value] : head.tags) add_tag(tag, name, value);
}

} // namespace kinora::container
