#include "kinora_recording/recording_writer.h"

#include "core/error.h"

namespace kinora::formats {

std::string RecordingWriter::write(const KinoraFrame& frame) {
  if (!recorder_) {
    recorder_.emplace(path_, description_, frame, sound_ ? &*sound_ : nullptr);
    for (const container::Payload& packet : early_sound_) recorder_->write_sound(packet);
    early_sound_.clear();
  }
  if (recorder_->write(frame)) return {};
  return "frame " + std::to_string(frame.index) + " does not fit the first one and is left out";
}

void RecordingWriter::write_sound(const KinoraSoundPacket& packet) {
  container::Payload payload = sound::payload_of(packet, description_.start_time);
  if (recorder_)
    recorder_->write_sound(payload);
  else
    early_sound_.push_back(std::move(payload));
}

void RecordingWriter::finish() {
  if (!recorder_) throw Error(ErrorCode::kFailure, path_.string() + ": a recording needs at least one frame");
  recorder_->finish();
}

} // namespace kinora::formats
