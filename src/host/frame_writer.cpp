#include "host/frame_writer.h"

#include "host/interface_struct.h"
#include "host/plugin_table.h"

namespace kinora::host {

FrameWriter::FrameWriter(const KinoraFormat& format, const std::filesystem::path& path, const Options& options,
                         const KinoraCaptureInfo& info)
    : format_(&format), writer_(open_writer(format, KINORA_WRITES_FRAMES, "captures", path, options)) {
  KinoraCaptureInfo given = info;
  given.warnings = nullptr;
  given.warning_count = 0;
  auto message = make_struct<KinoraMessage>();
  const KinoraStatus status = format.writer_capture(writer_.get(), &given, &message);
  if (status != KINORA_OK) throw error_of(status, message, format.name);
}

std::string FrameWriter::write(const KinoraFrame& frame) {
  KinoraFrame given = frame;
  if (!supports(*format_, KINORA_WRITES_CONFIDENCE)) given.confidence = {};
  if (!supports(*format_, KINORA_WRITES_INFRARED)) given.infrared = {};
  if (!supports(*format_, KINORA_WRITES_MASKS)) given.labels = {};
  if (!supports(*format_, KINORA_WRITES_POSES)) given.has_pose = 0;
  auto message = make_struct<KinoraMessage>();
  const KinoraStatus status = format_->writer_frame(writer_.get(), &given, &message);
  if (status == KINORA_OK) return {};
  const Error error = error_of(status, message, format_->name);
  if (status != KINORA_BAD_FRAME) throw error;
  return error.what();
}

void FrameWriter::set_sound(const KinoraSound& sound) {
  auto message = make_struct<KinoraMessage>();
  const KinoraStatus status = format_->writer_sound(writer_.get(), &sound, &message);
  if (status != KINORA_OK) throw error_of(status, message, format_->name);
}

void FrameWriter::write_sound(const KinoraSoundPacket& packet) {
  auto message = make_struct<KinoraMessage>();
  const KinoraStatus status = format_->writer_sound_packet(writer_.get(), &packet, &message);
  if (status != KINORA_OK) throw error_of(status, message, format_->name);
}

} // namespace kinora::host
