#include "container/writer.h"

#include <algorithm>
#include <array>
#include <map>
#include <set>

#include <ebml/EbmlVoid.h>
#include <fmt/format.h>
#include <matroska/KaxCluster.h>
#include <matroska/KaxClusterData.h>
#include <matroska/KaxCues.h>
#include <matroska/KaxCuesData.h>
#include <matroska/KaxSeekHead.h>
#include <matroska/KaxSegment.h>

#include "container/crc32c.h"
#include "container/envelope.h"
#include "container/file_sink.h"
#include "container/matroska_head.h"
#include "core/error.h"
#include "core/random.h"

namespace kinora::container {

using namespace libebml;
using namespace libmatroska;

namespace {

constexpr std::uint64_t kMaxClusterTicks = 30'000; // a block's time has 16 bits relative to its cluster
constexpr int kSizeBytes = 8;
constexpr std::size_t kLargestElement = (std::size_t{1} << 31) - 64; // libmatroska counts in 32 bits

std::uint64_t ticks(std::int64_t time_ns) {
  return (static_cast<std::uint64_t>(time_ns) + kTimestampScaleNs / 2) / kTimestampScaleNs;
}

[[noreturn]] void misuse(const std::string& sentence) { throw Error(ErrorCode::kFailure, sentence); }

void check_head(const FileHead& head) {
  if (head.tracks.empty()) misuse("a file needs at least one track");
  std::set<std::uint16_t> ids;
  for (const Track& track : head.tracks) {
    if (track.codec.starts_with(kCodecPrefix) == track.media.has_value())
      misuse(fmt::format("codec {} begins with S_KINORA/ if and only if it is ours", track.codec));
    if (!ids.insert(track.id).second) misuse(fmt::format("two tracks have the id {}", track.id));
  }
  for (const Chapter& chapter : head.chapters) {
    if (chapter.time_ns < 0) misuse(fmt::format("chapter {} begins before the start", chapter.title));
  }
  std::set<std::string> names;
  for (const Attachment& attachment : head.attachments) {
    if (attachment.bytes.size() > kLargestElement)
      misuse(fmt::format("attachment {} has 2 GB or more", attachment.name));
    if (!names.insert(attachment.name).second) misuse(fmt::format("two attachments are named {}", attachment.name));
  }
}

struct Pending {
  std::size_t track;  // place in the head
  std::uint64_t time; // ticks
  bool key;
  Bytes block;
};

struct Cue {
  std::uint64_t time;
  std::uint64_t track_number;
  std::uint64_t cluster_position;
  std::uint64_t relative_position;
};

} // namespace

class Writer::Impl {
public:
  Impl(const std::filesystem::path& path, const FileHead& head, const WriterOptions& options)
      : sink_(path), options_(options), duration_ns_(head.duration_ns) {
    check_head(head);
    for (std::size_t i = 0; i < head.tracks.size(); ++i) {
      track_indices_[head.tracks[i].id] = i;
      is_media_.push_back(head.tracks[i].media.has_value());
    }
    digest_head(head);
    write_head(head);
  }

  void write(std::uint16_t track, std::int64_t time_ns, bool key, std::span<const std::byte> bytes) {
    const auto index = track_indices_.find(track);
    if (index == track_indices_.end()) misuse(fmt::format("there is no track {} to write to", track));
    if (time_ns < last_time_ns_ && !options_.any_order)
      misuse(fmt::format("a payload at {} ns comes after one at {} ns", time_ns, last_time_ns_));
    if (bytes.size() > kLargestElement) misuse(fmt::format("a payload of track {} has 2 GB or more", track));
    Bytes block =
        is_media_[index->second] ? Bytes(bytes.begin(), bytes.end()) : wrap_payload(track, time_ns, key, bytes);
    digest(block);
    const std::uint64_t time = ticks(time_ns);
    if (!pending_.empty() && (pending_bytes_ + block.size() > options_.cluster_bytes ||
                              spanned_with(time) > std::min(ticks(options_.cluster_ns), kMaxClusterTicks))) {
      flush();
    }
    last_time_ns_ = std::max(last_time_ns_, time_ns);
    first_time_ = pending_.empty() ? time : std::min(first_time_, time);
    latest_time_ = pending_.empty() ? time : std::max(latest_time_, time);
    pending_bytes_ += block.size();
    pending_.push_back({index->second, time, key, std::move(block)});
  }

  void flush() {
    if (pending_.empty()) return;
    flush_cluster();
    sink_.flush(options_.durable);
    whole_bytes_ = sink_.getFilePointer();
  }

  void finish() {
    flush();
    const bool has_cues = write_cues();
    complete(has_cues);
  }

  void finish_at_last_cluster() {
    pending_.clear();
    sink_.cut(whole_bytes_);
    while (!cues_.empty() && segment_.GetDataStart() + cues_.back().cluster_position >= whole_bytes_) cues_.pop_back();
    bool has_cues = false;
    try {
      has_cues = write_cues();
      sink_.flush(false);
    } catch (const Error&) { // no room even for these: whoever seeks has to read
      has_cues = false;
      sink_.cut(whole_bytes_);
    }
    complete(has_cues);
  }

private:
  // SeekHead and Info have a fixed length: written first to keep their places, again when everything is known.
  void write_head(const FileHead& head) {
    EbmlHead ebml;
    fill_ebml_head(ebml);
    ebml.Render(sink_, true);
    segment_.SetSizeInfinite(true);
    segment_.WriteHead(sink_, kSizeBytes);
    write_unknown_size();
    seek_head_at_ = sink_.getFilePointer();
    has_attachments_ = !head.attachments.empty();
    has_chapters_ = !head.chapters.empty();
    write_seek_head(seek_head_at_, true);
    write_info();
    tracks_at_ = sink_.getFilePointer();
    fill_tracks(tracks_, head);
    tracks_.Render(sink_);
    attachments_at_ = sink_.getFilePointer();
    if (has_attachments_) {
      KaxAttachments attachments;
      fill_attachments(attachments, head);
      attachments.Render(sink_);
    }
    chapters_at_ = sink_.getFilePointer();
    if (has_chapters_) {
      KaxChapters chapters;
      fill_chapters(chapters, head);
      chapters.Render(sink_);
    }
    tags_at_ = sink_.getFilePointer();
    KaxTags tags;
    fill_tags(tags, head);
    tags.Render(sink_);
    const std::uint64_t end = sink_.getFilePointer();
    sink_.setFilePointer(static_cast<std::int64_t>(seek_head_at_)); // now that it is known where all of this is
    write_seek_head(0, false);
    sink_.setFilePointer(static_cast<std::int64_t>(end));
    sink_.flush(options_.durable);
    whole_bytes_ = end;
  }

  // What readers of an unfinished file must see; libebml writes a size of zero.
  void write_unknown_size() {
    constexpr std::array<std::uint8_t, kSizeBytes> kUnknown{0x01, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF};
    const std::uint64_t end = sink_.getFilePointer();
    sink_.setFilePointer(static_cast<std::int64_t>(end - kSizeBytes));
    sink_.write(kUnknown.data(), kUnknown.size());
    sink_.setFilePointer(static_cast<std::int64_t>(end));
  }

  // Everything but what stands at the front is written.
  void complete(bool has_cues) {
    const std::uint64_t end = sink_.getFilePointer();
    sink_.setFilePointer(static_cast<std::int64_t>(seek_head_at_));
    write_seek_head(whole_bytes_, has_cues);
    write_info();
    segment_.ForceSize(end - segment_.GetDataStart());
    segment_.OverwriteHead(sink_);
    sink_.flush(options_.durable);
    sink_.close();
  }

  void write_seek_head(std::uint64_t cues_at, bool has_cues) {
    KaxSeekHead seek_head;
    const auto add = [&](const EbmlId& id, std::uint64_t at) {
      auto& seek = AddNewChild<KaxSeek>(seek_head);
      std::array<binary, 4> id_bytes{};
      id.Fill(id_bytes.data());
      GetChild<KaxSeekID>(seek).CopyBuffer(id_bytes.data(), static_cast<std::uint32_t>(EBML_ID_LENGTH(id)));
      auto& position = GetChild<KaxSeekPosition>(seek);
      position.SetDefaultSize(kSizeBytes);
      static_cast<EbmlUInteger&>(position).SetValue(at - segment_.GetDataStart());
    };
    add(EBML_ID(KaxInfo), info_at_);
    add(EBML_ID(KaxTracks), tracks_at_);
    if (has_attachments_) add(EBML_ID(KaxAttachments), attachments_at_);
    if (has_chapters_) add(EBML_ID(KaxChapters), chapters_at_);
    add(EBML_ID(KaxTags), tags_at_);
    if (has_cues) {
      add(EBML_ID(KaxCues), cues_at);
      seek_head.Render(sink_);
      return;
    }
    const std::uint64_t room = info_at_ - sink_.getFilePointer();
    seek_head.Render(sink_);
    fill_with_void(room - seek_head.ElementSize());
  }

  void fill_with_void(std::uint64_t bytes) {
    EbmlVoid filler;
    filler.SetSize(bytes);
    filler.SetSize(bytes - (filler.ElementSize() - bytes));
    filler.Render(sink_);
  }

  void write_info() {
    info_at_ = sink_.getFilePointer();
    KaxInfo info;
    SegmentUid uid{};
    for (std::size_t i = 0; i < uid.size(); ++i) {
      uid[i] = static_cast<std::uint8_t>(digest_[i / 8] >> (8 * (i % 8)) & 0xFF);
    }
    fill_info(info, uid, std::max(duration_ns_, last_time_ns_));
    info.Render(sink_, true); // with the time scale, though it is the default
  }

  /// Ticks from the first to the last time of the cluster with one payload more.
  std::uint64_t spanned_with(std::uint64_t time) const {
    return std::max(time, latest_time_) - std::min(time, first_time_);
  }

  void flush_cluster() {
    if (pending_.empty()) return;
    KaxCluster cluster;
    cluster.SetParent(segment_);
    const std::uint64_t start = first_time_;
    cluster.InitTimecode(start, static_cast<std::int64_t>(kTimestampScaleNs));
    static_cast<EbmlUInteger&>(GetChild<KaxClusterTimecode>(cluster)).SetValue(start);
    std::vector<const KaxSimpleBlock*> blocks;
    for (Pending& pending : pending_) {
      auto& block = AddNewChild<KaxSimpleBlock>(cluster);
      block.SetParent(cluster);
      block.SetKeyframe(pending.key);
      // Owned by the block, which does not free what it did not allocate.
      auto* const buffer = new DataBuffer(reinterpret_cast<binary*>(pending.block.data()),
                                          static_cast<std::uint32_t>(pending.block.size()));
      block.AddFrame(static_cast<const KaxTrackEntry&>(*tracks_.GetElementList()[pending.track]),
                     pending.time * kTimestampScaleNs, *buffer, LACING_NONE);
      blocks.push_back(&block);
    }
    static_cast<EbmlMaster&>(cluster).Render(sink_);
    add_cues(cluster, blocks);
    pending_.clear();
    pending_bytes_ = 0;
  }

  // One for the first key payload of every track in the cluster: enough to enter there, and small.
  void add_cues(const KaxCluster& cluster, const std::vector<const KaxSimpleBlock*>& blocks) {
    std::set<std::size_t> seen;
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      if (!pending_[i].key || !seen.insert(pending_[i].track).second) continue;
      cues_.push_back({pending_[i].time, pending_[i].track + 1, cluster.GetElementPosition() - segment_.GetDataStart(),
                       blocks[i]->GetElementPosition() - cluster.GetDataStart()});
    }
  }

  bool write_cues() {
    if (cues_.empty()) return false;
    KaxCues cues;
    cues.SetGlobalTimecodeScale(kTimestampScaleNs);
    for (const Cue& cue : cues_) {
      auto& point = AddNewChild<KaxCuePoint>(cues);
      static_cast<EbmlUInteger&>(GetChild<KaxCueTime>(point)).SetValue(cue.time);
      auto& positions = GetChild<KaxCueTrackPositions>(point);
      static_cast<EbmlUInteger&>(GetChild<KaxCueTrack>(positions)).SetValue(cue.track_number);
      static_cast<EbmlUInteger&>(GetChild<KaxCueClusterPosition>(positions)).SetValue(cue.cluster_position);
      static_cast<EbmlUInteger&>(GetChild<KaxCueRelativePosition>(positions)).SetValue(cue.relative_position);
    }
    static_cast<EbmlMaster&>(cues).Render(sink_);
    return true;
  }

  // The segment's identifier is a digest of everything that was given to be written.
  void digest_head(const FileHead& head) {
    const auto text = [this](const std::string& value) { digest(std::as_bytes(std::span(value))); };
    text(head.kind);
    for (const Track& track : head.tracks) {
      text(track.codec);
      text(track.name);
      digest(wrap_private(track));
    }
    for (const Attachment& attachment : head.attachments) {
      text(attachment.name);
      text(attachment.media_type);
      text(attachment.description);
      digest(attachment.bytes);
    }
    for (const Chapter& chapter : head.chapters) {
      text(chapter.title);
      digest_value(static_cast<std::uint64_t>(chapter.time_ns));
    }
    for (const auto& [name, value] : head.tags) {
      text(name);
      text(value);
    }
    digest_value(static_cast<std::uint64_t>(head.duration_ns));
  }

  void digest_value(std::uint64_t value) {
    digest_[0] = mix64(digest_[0] ^ value);
    digest_[1] = mix64(digest_[1] + mix64(value));
  }
  void digest(std::span<const std::byte> bytes) { digest_value(std::uint64_t{bytes.size()} << 32 | crc32c(bytes)); }

  FileSink sink_;
  WriterOptions options_;
  std::vector<bool> is_media_;    // for each track
  std::uint64_t whole_bytes_ = 0; // of the file, up to the end of its last whole cluster
  KaxSegment segment_;
  KaxTracks tracks_;
  std::map<std::uint16_t, std::size_t> track_indices_;
  std::vector<Pending> pending_;
  std::size_t pending_bytes_ = 0;
  std::uint64_t first_time_ = 0, latest_time_ = 0; // of the pending ones, ticks
  std::vector<Cue> cues_;
  std::int64_t duration_ns_;
  std::int64_t last_time_ns_ = 0;
  std::array<std::uint64_t, 2> digest_{1, 2};
  bool has_attachments_ = false, has_chapters_ = false;
  std::uint64_t seek_head_at_ = 0, info_at_ = 0, tracks_at_ = 0, attachments_at_ = 0, chapters_at_ = 0, tags_at_ = 0;
};

Writer::Writer(const std::filesystem::path& path, const FileHead& head, const WriterOptions& options)
    : impl_(std::make_unique<Impl>(path, head, options)) {}
Writer::~Writer() = default;
void Writer::write(std::uint16_t track, std::int64_t time_ns, bool key, std::span<const std::byte> bytes) {
  impl_->write(track, time_ns, key, bytes);
}
void Writer::flush() { impl_->flush(); }
void Writer::finish() { impl_->finish(); }
void Writer::finish_at_last_cluster() { impl_->finish_at_last_cluster(); }

} // namespace kinora::container
