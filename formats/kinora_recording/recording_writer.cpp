#include "kinora_recording/recording_writer.h"

#include "core/error.h"

namespace kinora::formats {

std::string RecordingWriter::write(const KinoraFrame& frame) {
  if (!recorder_) recorder_.emplace(path_, description_, frame);
  if (recorder_->write(frame)) return {};
  return "frame " + std::to_string(frame.index) + " does not fit the first one and is left out";
}

void RecordingWriter::finish() {
  if (!recorder_) throw Error(ErrorCode::kFailure, path_.string() + ": a recording needs at least one frame");
  recorder_->finish();
}

} // namespace kinora::formats
