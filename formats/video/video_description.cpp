#include "video/video_description.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "video/libav_input.h"

extern "C" {
#include <libavutil/display.h>
}

namespace kinora::formats {
namespace {

constexpr int kMaxSide = 16384;

std::map<std::string, std::string> tags_of(const AVDictionary* dictionary) {
  std::map<std::string, std::string> tags;
  const AVDictionaryEntry* entry = nullptr;
  while ((entry = av_dict_get(dictionary, "", entry, AV_DICT_IGNORE_SUFFIX)) != nullptr)
    tags[entry->key] = entry->value;
  return tags;
}

bool has_pictures(const AVStream& stream) {
  const AVCodecParameters& parameters = *stream.codecpar;
  return parameters.codec_type == AVMEDIA_TYPE_VIDEO && (stream.disposition & AV_DISPOSITION_ATTACHED_PIC) == 0 &&
         parameters.width >= 1 && parameters.height >= 1 && parameters.width <= kMaxSide &&
         parameters.height <= kMaxSide;
}

/// Phones store pictures as the sensor lies and say how they are turned. Throws Error(kCorruptInput) for mirrors and
/// oblique angles.
int quarter_turns_of(const AVStream& stream, const std::filesystem::path& path) {
  std::size_t bytes = 0;
  const auto* matrix =
      reinterpret_cast<const std::int32_t*>(av_stream_get_side_data(&stream, AV_PKT_DATA_DISPLAYMATRIX, &bytes));
  if (matrix == nullptr || bytes < 9 * sizeof(std::int32_t)) return 0;
  const double determinant = double{1} * matrix[0] * matrix[4] - double{1} * matrix[1] * matrix[3];
  const double quarters = -av_display_rotation_get(matrix) / 90; // it counts counterclockwise
  if (!(determinant > 0) || std::abs(quarters - std::round(quarters)) > 1e-3)
    throw Error(ErrorCode::kCorruptInput,
                path.string() + ": its pictures are to be mirrored or turned by an odd angle, which is not done; "
                                "convert it first: ffmpeg -i IN -c:v ffv1 OUT.mkv");
  return (static_cast<int>(std::lround(quarters)) + 4) % 4;
}

VideoStream stream_of(const AVStream& stream, const std::filesystem::path& path) {
  VideoStream video;
  video.number = stream.index;
  video.codec = avcodec_get_name(stream.codecpar->codec_id);
  video.tags = tags_of(stream.metadata);
  video.width = stream.codecpar->width;
  video.height = stream.codecpar->height;
  video.quarter_turns = quarter_turns_of(stream, path);
  if (video.quarter_turns % 2 == 1) std::swap(video.width, video.height);
  video.gray16 = stream.codecpar->format == AV_PIX_FMT_GRAY16LE || stream.codecpar->format == AV_PIX_FMT_GRAY16BE;
  return video;
}

} // namespace

VideoDescription read_description(const std::filesystem::path& path) {
  const libav::Input input = open_input(path);
  VideoDescription description;
  description.tags = tags_of(input->metadata);
  std::map<int, std::vector<double>> times;
  for (unsigned i = 0; i < input->nb_streams; ++i) {
    AVStream& stream = *input->streams[i];
    if (has_pictures(stream)) {
      description.streams.push_back(stream_of(stream, path));
      times.emplace(stream.index, std::vector<double>());
      continue;
    }
    stream.discard = AVDISCARD_ALL;
    if (stream.codecpar->codec_type != AVMEDIA_TYPE_ATTACHMENT) continue;
    const auto* data = reinterpret_cast<const std::byte*>(stream.codecpar->extradata);
    const AVDictionaryEntry* name = av_dict_get(stream.metadata, "filename", nullptr, 0);
    if (name != nullptr && data != nullptr)
      description.attachments[name->value].assign(data, data + stream.codecpar->extradata_size);
  }
  const libav::Packet packet(av_packet_alloc());
  while (av_read_frame(input.get(), packet.get()) >= 0) {
    const auto stream = times.find(packet->stream_index);
    const std::int64_t shown = packet->pts != AV_NOPTS_VALUE ? packet->pts : packet->dts;
    if (stream != times.end() && shown != AV_NOPTS_VALUE && (packet->flags & AV_PKT_FLAG_DISCARD) == 0)
      stream->second.push_back(time_of(shown, *input->streams[packet->stream_index]));
    av_packet_unref(packet.get());
  }
  for (VideoStream& stream : description.streams) {
    stream.times = std::move(times[stream.number]);
    std::sort(stream.times.begin(), stream.times.end());
  }
  return description;
}

} // namespace kinora::formats
