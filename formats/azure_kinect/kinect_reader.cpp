#include "azure_kinect/kinect_reader.h"

#include "core/error.h"
#include "core/image_codec.h"

namespace kinora::formats {
namespace {

constexpr double kMaxTimeDifference = 0.02; ///< seconds between colour and depth
constexpr double kMillimetre = 0.001;
constexpr const char* kCalibrationFile = "calibration.json";

const VideoStream* stream_called(const VideoDescription& file, const std::string& title) {
  for (const VideoStream& stream : file.streams) {
    const auto name = stream.tags.find("title");
    if (name != stream.tags.end() && name->second == title) return &stream;
  }
  return nullptr;
}

} // namespace

bool is_kinect_recording(const VideoDescription& file) {
  return stream_called(file, "COLOR") != nullptr && stream_called(file, "DEPTH") != nullptr;
}

void KinectReader::fail(const std::string& problem) const {
  throw Error(ErrorCode::kCorruptInput, path_.string() + ": " + problem);
}

std::optional<KinectReader::Stream> KinectReader::open_stream(const VideoDescription& file, const char* title) const {
  const VideoStream* stream = stream_called(file, title);
  if (stream == nullptr || stream->times.empty()) return std::nullopt;
  return Stream{*stream, open_video(path_, *stream)};
}

KinectReader::KinectReader(const std::filesystem::path& path) : path_(path) {
  const VideoDescription file = describe_video(path);
  if (!is_kinect_recording(file))
    throw Error(ErrorCode::kNotRecognised, path.string() +
                                               ": not a recording of an Azure Kinect; it has no tracks COLOR "
                                               "and DEPTH");
  color_stream_ = open_stream(file, "COLOR");
  depth_stream_ = open_stream(file, "DEPTH");
  infrared_stream_ = open_stream(file, "IR");
  if (!color_stream_ || !depth_stream_) fail("has no picture of colour or of depth");
  const VideoStream& color = color_stream_->description;
  const VideoStream& depth = depth_stream_->description;
  const auto json = file.attachments.find(kCalibrationFile);
  if (json == file.attachments.end()) fail("has no attachment calibration.json; record it with k4arecorder");
  calibration_ = read_kinect_calibration(json->second, color.width, color.height, depth.width, depth.height,
                                         path.string() + ", " + kCalibrationFile);
  color_map_ = LensMap(calibration_.color);
  depth_map_ = LensMap(calibration_.depth);
  if (infrared_stream_ &&
      (infrared_stream_->description.width != depth.width || infrared_stream_->description.height != depth.height))
    infrared_stream_.reset();
  frames_ = pair_by_time(color.times, depth.times, kMaxTimeDifference);
  if (frames_.empty()) fail("no colour image has a depth image within 20 ms");
  if (frames_.size() < color.times.size())
    warnings_.push_back(path.string() + ": " + std::to_string(color.times.size() - frames_.size()) +
                        " colour images have no depth image within 20 ms and are left out");
  warning_table_.set(warnings_);
}

void KinectReader::fill_info(KinoraCaptureInfo& info) const {
  const std::vector<double>& times = color_stream_->description.times;
  info.frame_count = static_cast<std::int64_t>(frames_.size());
  info.start_time = times[frames_.front().first];
  info.frames_per_second = median_rate(times);
  info.camera = camera_of(calibration_.color.intrinsics, {});
  warning_table_.fill(info);
  set_depth_camera(info, camera_of(calibration_.depth.intrinsics, {}), calibration_.depth_to_color);
}

DepthImage16 KinectReader::read_gray(Stream& stream, std::size_t number) const {
  VideoPicture picture = stream.video->read(number);
  if (picture.gray16.empty()) fail("its pictures of depth have no 16 bits");
  return depth_map_.straighten(picture.gray16);
}

KinoraStatus KinectReader::next(KinoraFrame& frame) {
  if (next_ >= frames_.size()) return KINORA_END;
  frame.index = static_cast<std::int64_t>(next_);
  const auto [color, depth] = frames_[next_++];
  frame.time = color_stream_->description.times[color];
  VideoPicture picture = color_stream_->video->read(color);
  if (!picture.jpeg.empty())
    picture.color = decode_color(picture.jpeg, path_.string() + ", colour image " + std::to_string(color));
  if (picture.color.width() != calibration_.color.intrinsics.width ||
      picture.color.height() != calibration_.color.intrinsics.height)
    fail("colour image " + std::to_string(color) + " has another size than its track says");
  color_ = color_map_.straighten(picture.color);
  depth_ = read_gray(*depth_stream_, depth);
  if (infrared_stream_ && depth < infrared_stream_->description.times.size()) {
    infrared_ = read_gray(*infrared_stream_, depth);
    frame.infrared = view_of(infrared_, KINORA_PIXEL_U16);
  }
  frame.color = view_of(color_, KINORA_PIXEL_U8);
  frame.depth = view_of(depth_, KINORA_PIXEL_U16);
  frame.depth_unit = kMillimetre;
  return KINORA_OK;
}

void KinectReader::seek(std::int64_t index) { next_ = checked_seek(index, frames_.size()); }

} // namespace kinora::formats
