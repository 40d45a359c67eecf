#include "host/frame_reader.h"

#include <fmt/format.h>

#include "host/interface_struct.h"
#include "host/option_values.h"
#include "host/plugin_table.h"

namespace kinora::host {
namespace {

std::unique_ptr<KinoraReader, void (*)(KinoraReader*)>
open_reader(const KinoraFormat& format, const std::filesystem::path& path, const Options& options) {
  if (!supports(format, KINORA_READS_FRAMES))
    throw Error(ErrorCode::kUsage, fmt::format("the format {} cannot be read, only written", format.name));
  check_options(format, options);
  const std::vector<KinoraOptionValue> values = option_values(options);
  auto message = make_struct<KinoraMessage>();
  KinoraReader* reader = nullptr;
  const KinoraStatus status = format.open_reader(path.c_str(), values.data(), values.size(), &reader, &message);
  if (status != KINORA_OK) throw error_of(status, message, path.string());
  return {reader, format.reader_close};
}

} // namespace

FrameReader::FrameReader(const KinoraFormat& format, const std::filesystem::path& path, const Options& options)
    : format_(&format), reader_(open_reader(format, path, options)), info_(make_struct<KinoraCaptureInfo>()) {
  auto message = make_struct<KinoraMessage>();
  const KinoraStatus status = format_->reader_info(reader_.get(), &info_, &message);
  if (status != KINORA_OK) throw error_of(status, message, path.string());
}

std::optional<ReadFrame> FrameReader::next() {
  auto message = make_struct<KinoraMessage>();
  ReadFrame read{make_struct<KinoraFrame>(), {}};
  read.frame.index = position_;
  const KinoraStatus status = format_->reader_next(reader_.get(), &read.frame, &message);
  if (status == KINORA_END) return std::nullopt;
  ++position_;
  if (status == KINORA_BAD_FRAME)
    read.problem = error_of(status, message, format_->name).what();
  else if (status != KINORA_OK)
    throw error_of(status, message, format_->name);
  return read;
}

void FrameReader::seek(std::int64_t index) {
  if (index == position_) return;
  if (supports(*format_, KINORA_SEEKS)) {
    auto message = make_struct<KinoraMessage>();
    const KinoraStatus status = format_->reader_seek(reader_.get(), index, &message);
    if (status != KINORA_OK) throw error_of(status, message, format_->name);
    position_ = index;
    return;
  }
  if (index < position_)
    throw Error(ErrorCode::kFailure, fmt::format("the format {} cannot go back to frame {}", format_->name, index));
  while (position_ < index && next()) {
  }
}

} // namespace kinora::host
