#include "ros/log_reader.h"

#include "core/error.h"
#include "core/jpeg_decoder.h"
#include "ros/messages.h"
#include "ros/ros_images.h"

namespace kinora::formats {
namespace {

constexpr double kMaxTimeDifference = 0.02; ///< seconds between colour and depth

void check_size(int width, int height, const Intrinsics& camera, const std::string& source) {
  if (width == camera.width && height == camera.height) return;
  throw Error(ErrorCode::kCorruptInput, source + ": a picture is " + std::to_string(width) + "x" +
                                            std::to_string(height) + ", not " + std::to_string(camera.width) + "x" +
                                            std::to_string(camera.height) + " as its camera_info says");
}

} // namespace

LogReader::LogReader(MessageReader messages, const std::string& color_topic, const std::string& depth_topic)
    : messages_(std::move(messages)), topics_(find_camera_topics(messages_, color_topic, depth_topic)) {
  if (!topics_.depth_to_color) {
    const Intrinsics& color = topics_.color.intrinsics;
    check_size(topics_.depth.intrinsics.width, topics_.depth.intrinsics.height, color, messages_.name());
  }
  const std::string& problem = messages_.log().problem;
  if (!problem.empty()) topics_.warnings.push_back(problem + "; what stands before is read");
  pair_messages();
  warnings_.set(topics_.warnings);
}

std::vector<LogReader::Stamped> LogReader::stamped_messages(const CameraTopic& topic) {
  constexpr std::size_t kHeaderBytes = 4096; // a header has a short name
  std::vector<Stamped> stamped;
  const MessageLog& log = messages_.log();
  for (std::size_t i = 0; i < log.messages.size(); ++i) {
    LoggedMessage message = log.messages[i];
    if (message.channel != topic.channel) continue;
    double time = 1e-9 * static_cast<double>(message.time_ns);
    message.bytes = std::min<std::uint64_t>(message.bytes, kHeaderBytes);
    try {
      const std::vector<std::byte> head = messages_.read(message);
      const double stamp = stamp_of({head, log.channels[topic.channel].encoding, messages_.name()});
      if (stamp > 0) time = stamp;
    } catch (const Error&) { // the frame says so when it is read
    }
    stamped.push_back({time, i});
  }
  if (put_in_order(stamped))
    topics_.warnings.push_back(messages_.name() + ": the time stamps of " + log.channels[topic.channel].topic +
                               " are out of order; frames are taken in order of time");
  return stamped;
}

void LogReader::pair_messages() {
  const std::vector<Stamped> colors = stamped_messages(topics_.color);
  const std::vector<Stamped> depths = stamped_messages(topics_.depth);
  for (const auto& [color, depth] : pair_by_time(times_of(colors), times_of(depths), kMaxTimeDifference))
    frames_.push_back({colors[color].time, colors[color].message, depths[depth].message});
  if (frames_.empty())
    throw Error(ErrorCode::kCorruptInput, messages_.name() + ": no colour image has a depth image within 20 ms");
  if (frames_.size() < colors.size())
    topics_.warnings.push_back(messages_.name() + ": " + std::to_string(colors.size() - frames_.size()) +
                               " colour images have no depth image within 20 ms and are left out");
  frames_per_second_ = median_rate(times_of(frames_));
}

void LogReader::fill_info(KinoraCaptureInfo& info) const {
  info.frame_count = static_cast<std::int64_t>(frames_.size());
  info.start_time = frames_.front().time;
  info.frames_per_second = frames_per_second_;
  info.camera = camera_of(topics_.color.intrinsics, topics_.color.distortion);
  warnings_.fill(info);
  if (topics_.depth_to_color)
    set_depth_camera(info, camera_of(topics_.depth.intrinsics, topics_.depth.distortion), *topics_.depth_to_color);
}

MessageBytes LogReader::bytes_of(std::size_t message, std::vector<std::byte>& bytes) {
  const LoggedMessage& logged = messages_.log().messages[message];
  bytes = messages_.read(logged);
  const Channel& channel = messages_.log().channels[logged.channel];
  return {bytes, channel.encoding, messages_.name() + ", " + channel.topic + ", frame " + std::to_string(next_ - 1)};
}

void LogReader::read_color(std::size_t message, KinoraFrame& frame) {
  const MessageBytes bytes = bytes_of(message, color_bytes_);
  const bool compressed = topics_.color.compressed;
  const ImageMessage image = image_of(bytes, compressed);
  color_ = color_image_of(image, compressed, bytes.source);
  check_size(color_.width(), color_.height(), topics_.color.intrinsics, bytes.source);
  frame.color = view_of(color_, KINORA_PIXEL_U8);
  if (!compressed || frame.struct_size < sizeof(KinoraFrame) || !is_jpeg(image.data)) return;
  frame.color_jpeg = image.data.data();
  frame.color_jpeg_bytes = image.data.size();
}

KinoraStatus LogReader::next(KinoraFrame& frame) {
  if (next_ >= frames_.size()) return KINORA_END;
  frame.index = static_cast<std::int64_t>(next_);
  const Frame& entry = frames_[next_++];
  frame.time = entry.time;
  read_color(entry.color, frame);
  const MessageBytes bytes = bytes_of(entry.depth, depth_bytes_);
  depth_ = depth_image_of(image_of(bytes, topics_.depth.compressed), topics_.depth.compressed, bytes.source);
  check_size(depth_.width(), depth_.height(), topics_.depth.intrinsics, bytes.source);
  frame.depth = view_of(depth_, KINORA_PIXEL_U16);
  frame.depth_unit = topics_.depth_unit;
  return KINORA_OK;
}

void LogReader::seek(std::int64_t index) { next_ = checked_seek(index, frames_.size()); }

} // namespace kinora::formats
