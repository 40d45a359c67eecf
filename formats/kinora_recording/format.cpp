#include "kinora_recording/format.h"

#include <iterator>

#include "common/captures.h"
#include "kinora_recording/recording_reader.h"
#include "kinora_recording/recording_writer.h"

namespace kinora::formats {
namespace {

void probe_recording(const char* path, KinoraProbe* answer) {
  const auto [confidence, reason] = recording::recognise_recording(path);
  answer_probe(answer, confidence, reason);
}

std::unique_ptr<RecordingReader> open_reader(const char* path, const OptionMap& options) {
  return std::make_unique<RecordingReader>(path, option_is_set(options, "masks", true));
}

std::unique_ptr<RecordingWriter> open_writer(const char* path, const OptionMap& /*options*/) {
  return std::make_unique<RecordingWriter>(path);
}

constexpr KinoraOption kOptions[] = {{"masks", "bool", "true", "Read the masks that were recorded.", nullptr}};

constexpr KinoraFormat recording_format() {
  auto format = make_struct<KinoraFormat>();
  format.name = "kinora-recording";
  format.description = "what kinora record makes, and the recording in a clip of kinora encode --archive";
  format.extensions = ".mkv";
  format.capabilities = KINORA_READS_POSES | KINORA_READS_MASKS | KINORA_READS_CONFIDENCE | KINORA_READS_INFRARED |
                        KINORA_WRITES_TIMES | KINORA_WRITES_POSES | KINORA_WRITES_MASKS | KINORA_WRITES_CONFIDENCE |
                        KINORA_WRITES_INFRARED | KINORA_WRITES_DEPTH_CAMERA;
  format.options = kOptions;
  format.option_count = std::size(kOptions);
  format.probe = safe_probe<probe_recording>;
  set_reader<RecordingReader, open_reader>(format);
  set_writer<RecordingWriter, open_writer>(format);
  return format;
}

} // namespace

constinit const KinoraFormat kRecordingFormat = recording_format();

} // namespace kinora::formats
