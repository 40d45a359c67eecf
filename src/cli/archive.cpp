#include "cli/archive.h"

#include <optional>

#include <fmt/format.h>

#include "cli/sound_input.h"
#include "cli/unfinished.h"
#include "container/recovery.h"
#include "core/error.h"
#include "record/recorder.h"

namespace kinora::cli {
namespace {

void record_all(host::FrameReader& reader, sound::SoundSource* sound, const std::filesystem::path& path,
                Progress& progress) {
  const recording::Description description = recording::description_of(reader.info(), reader.format().name);
  std::optional<record::Recorder> recorder;
  std::optional<sound::SoundFeed> feed;
  if (sound != nullptr) feed.emplace(*sound);
  container::Payload packet;
  double last_time = 0;
  while (const auto read = reader.next()) {
    progress.check();
    const KinoraFrame& frame = read->frame;
    if (!read->problem.empty()) {
      if (recorder) recorder->write_problem(frame.index, last_time, read->problem);
      continue;
    }
    if (!recorder) recorder.emplace(path, description, frame, sound != nullptr ? &sound->track() : nullptr);
    while (feed && feed->next_until(nanoseconds_of(frame.time, reader.info()), packet)) recorder->write_sound(packet);
    if (!recorder->write(frame))
      progress.warn(fmt::format("frame {} does not fit the first one and is not archived", frame.index));
    last_time = frame.time;
    progress.advance(static_cast<std::size_t>(frame.index) + 1, "");
  }
  if (!recorder) throw Error(ErrorCode::kCorruptInput, "the capture has no frame that can be archived");
  recorder->finish();
}

} // namespace

void write_archive(const std::filesystem::path& clip_file, const std::filesystem::path& capture,
                   const CaptureReading& reading, const std::filesystem::path& audio,
                   const std::filesystem::path& output, Context& context) {
  host::FrameReader reader = open_frames(capture, reading, context);
  const Unfinished recording(output, Unfinished::Kind::kFile);
  context.progress.stage("archiving", static_cast<std::size_t>(reader.info().frame_count));
  const std::unique_ptr<sound::SoundSource> sound = open_sound_of(reader, audio);
  record_all(reader, sound.get(), recording.path(), context.progress);
  container::append_file(clip_file, recording.path(), output, context.progress);
}

} // namespace kinora::cli
