#include "host/frame_reader.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "host/frame_fault.h"
#include "host/interface_struct.h"
#include "host/option_values.h"
#include "host/plugin_table.h"

namespace kinora::host {
namespace {

constexpr double kMaxDistortion = 100; ///< as for calibration files

[[noreturn]] void refuse(const KinoraFormat& format, const std::string& fault) {
  throw Error(ErrorCode::kFailure,
              fmt::format("the plugin of the format {} {}; get a corrected build of it", format.name, fault));
}

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
  if (reader == nullptr) refuse(format, "opened " + path.string() + " and gave no reader");
  return {reader, format.reader_close};
}

bool has_usable_distortion(const KinoraCamera& camera) {
  return std::all_of(std::begin(camera.distortion), std::end(camera.distortion),
                     [](double value) { return std::abs(value) < kMaxDistortion; });
}

/// A plugin is not trusted: whatever is used without a further look must be as plugin.h says.
void check_info(const KinoraFormat& format, const KinoraCaptureInfo& info) {
  if (info.frame_count < 1) refuse(format, "gave a capture without frames");
  if (!std::isfinite(info.start_time) || !std::isfinite(info.frames_per_second) || info.frames_per_second <= 0)
    refuse(format, "gave a start time or a rate of frames that makes no sense");
  if (!has_usable_distortion(info.camera) || (info.has_depth_camera != 0 && !has_usable_distortion(info.depth_camera)))
    refuse(format, "gave an absurd lens distortion");
  if (info.label_count > 0 && info.labels == nullptr) refuse(format, "gave no list of labels, but a number of them");
  for (std::size_t i = 0; i < info.label_count; ++i) {
    const KinoraLabel& label = info.labels[i];
    if (label.label < 0 || label.label > 255 || label.name == nullptr || label.kind == nullptr)
      refuse(format, "gave a label without name or kind, or outside of 0 to 255");
  }
  if (info.warning_count > 0 && info.warnings == nullptr)
    refuse(format, "gave no list of warnings, but a number of them");
  for (std::size_t i = 0; i < info.warning_count; ++i)
    if (info.warnings[i] == nullptr) refuse(format, "gave a warning without a text");
}

} // namespace

FrameReader::FrameReader(const KinoraFormat& format, const std::filesystem::path& path, const Options& options)
    : format_(&format), reader_(open_reader(format, path, options)), info_(make_struct<KinoraCaptureInfo>()) {
  auto message = make_struct<KinoraMessage>();
  const KinoraStatus status = format_->reader_info(reader_.get(), &info_, &message);
  if (status != KINORA_OK) throw error_of(status, message, path.string());
  check_info(format, info_);
}

std::optional<ReadFrame> FrameReader::next() {
  if (!device_) return read_next();
  std::uint32_t dropped = pass_over_lost();
  while (std::optional<ReadFrame> read = read_next()) {
    if (read->problem.empty()) {
      last_time_ = read->frame.time;
      const SimulatedDevice::Delivery delivery = device_->wait_for(read->frame.time);
      if (delivery == SimulatedDevice::Delivery::kEnded) return std::nullopt;
      if (delivery == SimulatedDevice::Delivery::kLost) {
        dropped += 1 + pass_over_lost();
        continue;
      }
    }
    read->dropped_before = dropped;
    return read;
  }
  return std::nullopt;
}

// Frames that are lost, as far as the rate tells, need not be read. Returns how many they are.
std::uint32_t FrameReader::pass_over_lost() {
  if (!last_time_) return 0;
  const double expected = *last_time_ + 1 / info_.frames_per_second;
  const double lost = std::ceil(device_->overdue(expected) * info_.frames_per_second);
  const auto left = static_cast<double>(info_.frame_count - position_);
  const auto count = static_cast<std::int64_t>(std::clamp(lost, 0.0, std::max(left, 0.0)));
  seek(position_ + count);
  return static_cast<std::uint32_t>(count);
}

std::optional<ReadFrame> FrameReader::read_next() {
  auto message = make_struct<KinoraMessage>();
  ReadFrame read{make_struct<KinoraFrame>(), {}, 0};
  read.frame.index = position_;
  const KinoraStatus status = format_->reader_next(reader_.get(), &read.frame, &message);
  if (status == KINORA_END) return std::nullopt;
  ++position_;
  if (status == KINORA_BAD_FRAME)
    read.problem = error_of(status, message, format_->name).what();
  else if (status != KINORA_OK)
    throw error_of(status, message, format_->name);
  else if (const std::string fault = fault_of(read.frame, info_); !fault.empty())
    read.problem = fmt::format("{} {}", format_->name, fault);
  return read;
}

std::optional<KinoraSound> FrameReader::sound() {
  if (!supports(*format_, KINORA_READS_SOUND)) return std::nullopt;
  auto message = make_struct<KinoraMessage>();
  auto sound = make_struct<KinoraSound>();
  const KinoraStatus status = format_->reader_sound(reader_.get(), &sound, &message);
  if (status == KINORA_END) return std::nullopt;
  if (status != KINORA_OK) throw error_of(status, message, format_->name);
  return sound;
}

std::optional<KinoraSoundPacket> FrameReader::next_sound() {
  auto message = make_struct<KinoraMessage>();
  auto packet = make_struct<KinoraSoundPacket>();
  const KinoraStatus status = format_->reader_sound_packet(reader_.get(), &packet, &message);
  if (status == KINORA_END) return std::nullopt;
  if (status != KINORA_OK) throw error_of(status, message, format_->name);
  return packet;
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
  while (position_ < index && read_next()) {
  }
}

} // namespace kinora::host
