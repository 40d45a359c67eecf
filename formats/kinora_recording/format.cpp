#include "kinora_recording/format.h"

#include <iterator>

#include "common/boundary.h"
#include "kinora_recording/recording_reader.h"

/// What the interface calls a reader is, for this format, a RecordingReader.
struct KinoraReader {
  kinora::formats::RecordingReader reader;
};

namespace kinora::formats {
namespace {

void probe_recording(const char* path, KinoraProbe* answer) {
  const auto [confidence, reason] = recording::recognise_recording(path);
  answer->confidence = confidence;
  std::snprintf(answer->reason, sizeof answer->reason, "%s", reason.c_str());
}

KinoraStatus open_recording(const char* path, const KinoraOptionValue* options, size_t option_count,
                            KinoraReader** reader, KinoraMessage* message) {
  return guarded(message, [&] {
    const auto given = option_map(options, option_count);
    const auto masks = given.find("masks");
    *reader = new KinoraReader{RecordingReader(path, masks == given.end() || masks->second != "false")};
    return KINORA_OK;
  });
}

KinoraStatus recording_info(KinoraReader* reader, KinoraCaptureInfo* info, KinoraMessage* message) {
  return guarded(message, [&] {
    reader->reader.fill_info(*info);
    return KINORA_OK;
  });
}

KinoraStatus next_recorded(KinoraReader* reader, KinoraFrame* frame, KinoraMessage* message) {
  const KinoraStatus status = guarded(message, [&] { return reader->reader.next(*frame); });
  return status == KINORA_CORRUPT ? KINORA_BAD_FRAME : status;
}

KinoraStatus seek_recorded(KinoraReader* reader, int64_t index, KinoraMessage* message) {
  return guarded(message, [&] {
    reader->reader.seek(index);
    return KINORA_OK;
  });
}

void close_recording(KinoraReader* reader) { delete reader; }

const KinoraOption kOptions[] = {{"masks", "bool", "true", "Read the masks that were recorded.", nullptr}};

constexpr KinoraFormat recording_format() {
  auto format = make_struct<KinoraFormat>();
  format.name = "kinora-recording";
  format.description = "what kinora record makes, and the recording in a clip of kinora encode --archive";
  format.extensions = "";
  format.capabilities = KINORA_READS_FRAMES | KINORA_SEEKS | KINORA_READS_POSES | KINORA_READS_MASKS |
                        KINORA_READS_CONFIDENCE | KINORA_READS_INFRARED;
  format.options = kOptions;
  format.option_count = std::size(kOptions);
  format.probe = probe_recording;
  format.open_reader = open_recording;
  format.reader_info = recording_info;
  format.reader_next = next_recorded;
  format.reader_seek = seek_recorded;
  format.reader_close = close_recording;
  return format;
}

} // namespace

constinit const KinoraFormat kRecordingFormat = recording_format();

} // namespace kinora::formats
