#include "container/recovery.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include <fmt/format.h>

#include "container/reader.h"
#include "container/writer.h"
#include "core/error.h"

namespace kinora::container {

namespace {

/// What the writer calls a track that is not ours: its id is not stored. `base`: of a second file, others.
std::uint16_t id_of_other(std::size_t index, std::size_t base = 0) {
  return static_cast<std::uint16_t>(0xFFFF - base - index);
}

FileHead head_of(Reader& reader, Recovery& recovery, std::size_t base = 0) {
  FileHead head;
  for (const auto& [name, value] : reader.tags()) {
    if (name == kKindTag) {
      head.kind = value;
    } else if (name != kVersionTag) {
      head.tags.emplace_back(name, value);
    }
  }
  if (head.kind.empty()) {
    throw Error(
        ErrorCode::kCorruptInput,
        fmt::format("{}: the tags that say what the file is are lost; nothing can be recovered", reader.name()));
  }
  for (std::size_t i = 0; i < reader.tracks().size(); ++i) {
    const StoredTrack& stored = reader.tracks()[i];
    Track track = stored.track;
    if (!stored.ours) track.id = id_of_other(i, base);
    if (stored.encoded_again) {
      recovery.lost.push_back(
          fmt::format("track {} ({}) was compressed once more and is left out", track.name, track.codec));
    } else {
      head.tracks.push_back(std::move(track));
    }
  }
  head.chapters = reader.chapters();
  for (const StoredAttachment& stored : reader.attachments()) {
    try {
      head.attachments.push_back({stored.name, stored.media_type, stored.description, reader.read_attachment(stored)});
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kCorruptInput) throw;
      recovery.lost.emplace_back(error.what());
    }
  }
  return head;
}

void copy(Reader& reader, const StoredBlock& block, Writer& writer, Recovery& recovery, std::size_t base = 0) {
  const StoredTrack& track = reader.tracks()[block.track];
  if (track.ours) {
    const Payload payload = reader.read_payload(block);
    writer.write(payload.track, payload.time_ns, payload.key, payload.bytes);
    ++recovery.payloads;
  } else if (!track.encoded_again && block.lacing == Lacing::kNone) {
    writer.write(id_of_other(block.track, base), std::max<std::int64_t>(block.time_ns, 0), block.key,
                 reader.read_block(block));
    ++recovery.blocks;
  }
}

void verify(const std::filesystem::path& output, std::size_t payloads) {
  Reader reader(output);
  Payload payload;
  std::size_t count = 0;
  while (reader.next(payload)) ++count;
  if (count == payloads && reader.finished()) return;
  throw Error(ErrorCode::kFailure, fmt::format("{}: of {} payloads {} can be read back; the disk may be faulty",
                                               output.string(), payloads, count));
}

} // namespace

Recovery recover(const std::filesystem::path& input, const std::filesystem::path& output, Progress& progress) {
  Reader reader(input, Reading::kSalvage);
  Recovery recovery;
  recovery.file_bytes = reader.file_bytes();
  WriterOptions options;
  options.any_order = true;
  Writer writer(output, head_of(reader, recovery), options);
  StoredBlock block;
  while (reader.next_block(block)) {
    progress.check();
    copy(reader, block, writer, recovery);
  }
  writer.finish();
  recovery.damage = reader.damage();
  recovery.finished = reader.finished();
  verify(output, recovery.payloads);
  return recovery;
}

void append_file(const std::filesystem::path& main, const std::filesystem::path& other,
                 const std::filesystem::path& output, Progress& progress) {
  Reader first(main);
  Reader second(other);
  Recovery copied;
  FileHead head = head_of(first, copied);
  const std::size_t base = first.tracks().size();
  FileHead behind = head_of(second, copied, base);
  std::move(behind.tracks.begin(), behind.tracks.end(), std::back_inserter(head.tracks));
  std::move(behind.attachments.begin(), behind.attachments.end(), std::back_inserter(head.attachments));
  if (!copied.lost.empty()) throw Error(ErrorCode::kCorruptInput, copied.lost.front());
  WriterOptions options;
  options.any_order = true;
  Writer writer(output, head, options);
  StoredBlock block;
  for (const auto& [reader, place] : {std::pair(&first, std::size_t{0}), std::pair(&second, base)}) {
    while (reader->next_block(block)) {
      progress.check();
      copy(*reader, block, writer, copied, place);
    }
    writer.flush();
  }
  writer.finish();
}

} // namespace kinora::container
