#include "video_pair/pair_reader.h"

#include "common/files.h"
#include "core/error.h"
#include "core/image_codec.h"
#include "sound/plugin_sound.h"
#include "sound/sound_codec.h"

namespace kinora::formats {
namespace fs = std::filesystem;

namespace {

constexpr double kMaxTimeDifference = 0.02; ///< seconds between colour and depth
constexpr double kMillimetre = 0.001;

std::string lower_case(std::string text) {
  for (char& letter : text) letter = static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
  return text;
}

bool is_video_name(const fs::path& path) {
  const std::string extension = lower_case(path.extension().string());
  return extension == ".mkv" || extension == ".mp4" || extension == ".mov" || extension == ".avi" ||
         extension == ".webm";
}

VideoStream stream_of(const fs::path& path) {
  VideoDescription video = describe_video(path);
  if (video.streams.empty() || video.streams.front().times.empty())
    throw Error(ErrorCode::kCorruptInput, path.string() + ": holds no pictures");
  return std::move(video.streams.front());
}

ColorImage color_of(VideoPicture picture, const fs::path& path) {
  if (!picture.jpeg.empty()) return decode_color(picture.jpeg, path.string());
  return std::move(picture.color);
}

} // namespace

std::optional<VideoPair> find_video_pair(const fs::path& folder) {
  std::vector<fs::path> colors;
  std::vector<fs::path> depths;
  for (const fs::path& path : list_files(folder)) {
    if (!is_video_name(path)) continue;
    const bool depth = lower_case(path.stem().string()).find("depth") != std::string::npos;
    (depth ? depths : colors).push_back(path);
  }
  if (colors.size() != 1 || depths.size() != 1) return std::nullopt;
  return VideoPair{colors.front(), depths.front()};
}

PairReader::PairReader(const fs::path& folder, const HueRange& hue) : hue_(hue) {
  const std::optional<VideoPair> files = find_video_pair(folder);
  if (!files)
    throw Error(ErrorCode::kNotRecognised,
                folder.string() +
                    ": not a pair of videos; it needs one video with \"depth\" in its name and one without");
  if (!(hue.near >= 0 && hue.far > hue.near && hue.far <= 32))
    throw Error(ErrorCode::kUsage, "-O near and far are metres, from 0 to 32, and far is more than near");
  files_ = *files;
  color_stream_ = stream_of(files_.color);
  depth_stream_ = stream_of(files_.depth);
  if (color_stream_.width != depth_stream_.width || color_stream_.height != depth_stream_.height)
    throw Error(ErrorCode::kCorruptInput, files_.depth.string() + ": has pictures of another size than " +
                                              files_.color.filename().string() +
                                              "; register depth to colour first (one depth pixel per colour pixel)");
  calibration_ = read_calibration({folder});
  Intrinsics& k = calibration_.intrinsics;
  if ((k.width != 0 && k.width != color_stream_.width) || (k.height != 0 && k.height != color_stream_.height))
    throw Error(ErrorCode::kCorruptInput, calibration_.source.string() + ": is for pictures of another size than " +
                                              files_.color.string() + " has");
  k.width = color_stream_.width;
  k.height = color_stream_.height;
  k.validate(calibration_.source.string());
  color_video_ = open_video(files_.color, color_stream_);
  depth_video_ = open_video(files_.depth, depth_stream_);
  frames_ = pair_by_time(color_stream_.times, depth_stream_.times, kMaxTimeDifference);
  if (frames_.empty())
    throw Error(ErrorCode::kCorruptInput,
                files_.depth.string() + ": has no picture within 20 ms of one of " + files_.color.filename().string());
  if (frames_.size() < color_stream_.times.size())
    warnings_.push_back(files_.color.string() + ": " + std::to_string(color_stream_.times.size() - frames_.size()) +
                        " pictures have no depth within 20 ms and are left out");
  if (!depth_stream_.gray16)
    warnings_.push_back(files_.depth.string() + ": is read as hue from " + std::to_string(hue.near) + " to " +
                        std::to_string(hue.far) + " m; -O near=METRES and far=METRES change that");
  warning_table_.set(warnings_);
}

void PairReader::fill_info(KinoraCaptureInfo& info) const {
  info.frame_count = static_cast<std::int64_t>(frames_.size());
  info.start_time = color_stream_.times[frames_.front().first];
  info.frames_per_second = median_rate(color_stream_.times);
  info.camera = camera_of(calibration_.intrinsics, calibration_.distortion);
  warning_table_.fill(info);
}

KinoraStatus PairReader::next(KinoraFrame& frame) {
  if (next_ >= frames_.size()) return KINORA_END;
  frame.index = static_cast<std::int64_t>(next_);
  const auto [color, depth] = frames_[next_++];
  frame.time = color_stream_.times[color];
  VideoPicture shown = color_video_->read(color);
  jpeg_ = shown.jpeg;
  color_ = color_of(std::move(shown), files_.color);
  VideoPicture measured = depth_video_->read(depth);
  if (!measured.gray16.empty()) {
    depth_ = std::move(measured.gray16);
    frame.depth_unit = calibration_.depth_unit.value_or(kMillimetre);
  } else {
    depth_ = depth_of_hue(color_of(std::move(measured), files_.depth), hue_);
    frame.depth_unit = kHueDepthUnit;
  }
  if (color_.width() != color_stream_.width || !depth_.same_size(color_))
    throw Error(ErrorCode::kCorruptInput, files_.color.string() + ": a picture has another size than the video says");
  frame.color = view_of(color_, KINORA_PIXEL_U8);
  frame.depth = view_of(depth_, KINORA_PIXEL_U16);
  if (jpeg_.empty() || frame.struct_size < sizeof(KinoraFrame)) return KINORA_OK;
  frame.color_jpeg = jpeg_.data();
  frame.color_jpeg_bytes = jpeg_.size();
  return KINORA_OK;
}

void PairReader::seek(std::int64_t index) { next_ = checked_seek(index, frames_.size()); }

bool PairReader::fill_sound(KinoraSound& sound) {
  try {
    sound_ = sound::open_sound(files_.color);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kCorruptInput) throw;
    return false; // it has none
  }
  sound::fill(sound, sound_->track());
  return true;
}

bool PairReader::next_sound(KinoraSoundPacket& packet) {
  if (!sound_ || !sound_->next(sound_packet_)) return false;
  sound::fill(packet, sound_packet_, 0);
  return true;
}

} // namespace kinora::formats
