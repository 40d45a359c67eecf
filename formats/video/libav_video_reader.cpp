#include "video/libav_video_reader.h"

#include <cmath>
#include <cstring>

#include "core/error.h"
#include "video/turned.h"

extern "C" {
#include <libavutil/pixdesc.h>
#include <libswscale/swscale.h>
}

namespace kinora::formats {
namespace {

constexpr std::size_t kStepsWithoutSeek = 30;
constexpr double kSameTime = 1e-6;
constexpr std::int64_t kMaxPixels = std::int64_t{1} << 26;

} // namespace

void LibavVideoReader::ReleaseScaler::operator()(SwsContext* scaler) const { sws_freeContext(scaler); }

LibavVideoReader::LibavVideoReader(const std::filesystem::path& path, VideoStream stream)
    : path_(path), stream_(std::move(stream)), packet_(av_packet_alloc()), frame_(av_frame_alloc()) {
  open();
  if (stream_.codec != "mjpeg" || stream_.quarter_turns != 0) open_decoder(); // a JPEG file is not turned
}

void LibavVideoReader::fail(const std::string& problem) const {
  throw Error(ErrorCode::kCorruptInput, path_.string() + ": " + problem);
}

/// When a later picture has come in its place, or none.
void LibavVideoReader::fail_at(std::size_t number) const {
  fail("picture " + std::to_string(number) + " cannot be decoded, or is out of order");
}

void LibavVideoReader::open() {
  input_ = open_input(path_);
  if (stream_.number < 0 || static_cast<unsigned>(stream_.number) >= input_->nb_streams) fail("has changed meanwhile");
  for (unsigned i = 0; i < input_->nb_streams; ++i)
    if (static_cast<int>(i) != stream_.number) input_->streams[i]->discard = AVDISCARD_ALL;
}

void LibavVideoReader::open_decoder() {
  const AVCodecParameters& parameters = *input_->streams[stream_.number]->codecpar;
  decoder_ =
      libav::make_codec(avcodec_find_decoder(parameters.codec_id),
                        path_.string() + ": libavcodec has no decoder for " + stream_.codec + "; install one that has");
  decoder_->max_pixels = kMaxPixels;
  decoder_->thread_count = 0;
  decoder_->pkt_timebase = input_->streams[stream_.number]->time_base;
  int result = avcodec_parameters_to_context(decoder_.get(), &parameters);
  if (result >= 0) result = avcodec_open2(decoder_.get(), decoder_->codec, nullptr);
  libav::check(result, ErrorCode::kCorruptInput, path_.string() + ": the video cannot be decoded");
}

bool LibavVideoReader::next_packet() {
  do {
    av_packet_unref(packet_.get());
    if (av_read_frame(input_.get(), packet_.get()) < 0) return false;
  } while (packet_->stream_index != stream_.number);
  return true;
}

/// The next decoded picture in frame_; packets that are damaged are passed over.
bool LibavVideoReader::next_frame() {
  for (;;) {
    const int result = avcodec_receive_frame(decoder_.get(), frame_.get());
    if (result >= 0) return true;
    if (result != AVERROR(EAGAIN)) return false;
    if (drained_) return false;
    drained_ = !next_packet();
    (void)avcodec_send_packet(decoder_.get(), drained_ ? nullptr : packet_.get());
  }
}

void LibavVideoReader::go_to(std::size_t number) {
  if (number >= next_ && number - next_ <= kStepsWithoutSeek) return;
  const AVStream& stream = *input_->streams[stream_.number];
  const auto timestamp = std::llround(stream_.times[number] / av_q2d(stream.time_base));
  if (number == 0 || av_seek_frame(input_.get(), stream_.number, timestamp, AVSEEK_FLAG_BACKWARD) < 0) open();
  picture_waits_ = drained_ = false;
  if (decoder_) avcodec_flush_buffers(decoder_.get());
}

VideoPicture LibavVideoReader::read_jpeg(std::size_t number) {
  const double time = stream_.times[number];
  for (;;) {
    if (!picture_waits_ && !next_packet()) fail("ends too early");
    picture_waits_ = true;
    const std::int64_t stamp = packet_->pts != AV_NOPTS_VALUE ? packet_->pts : packet_->dts;
    const double shown = time_of(stamp, *input_->streams[stream_.number]);
    if (shown > time + kSameTime) fail_at(number);
    picture_waits_ = false;
    if (shown < time - kSameTime) continue;
    VideoPicture picture;
    const auto* data = reinterpret_cast<const std::byte*>(packet_->data);
    picture.jpeg.assign(data, data + packet_->size);
    return picture;
  }
}

VideoPicture LibavVideoReader::read(std::size_t number) {
  if (number >= stream_.times.size()) fail("has no picture " + std::to_string(number));
  go_to(number);
  next_ = number + 1;
  if (!decoder_) return read_jpeg(number);
  const double time = stream_.times[number];
  const AVStream& stream = *input_->streams[stream_.number];
  for (;;) {
    if (!picture_waits_ && !next_frame()) fail_at(number);
    picture_waits_ = true;
    const double shown = time_of(frame_->best_effort_timestamp, stream);
    if (shown > time + kSameTime) fail_at(number);
    picture_waits_ = false;
    if (shown >= time - kSameTime) return picture_of(*frame_);
  }
}

VideoPicture LibavVideoReader::picture_of(const AVFrame& frame) {
  const bool lies = stream_.quarter_turns % 2 == 1;
  if (frame.width != (lies ? stream_.height : stream_.width) || frame.height != (lies ? stream_.width : stream_.height))
    fail("its pictures change their size");
  VideoPicture picture;
  if (frame.format == AV_PIX_FMT_GRAY16LE || frame.format == AV_PIX_FMT_GRAY16BE) {
    picture.gray16 = DepthImage16(frame.width, frame.height);
    for (int v = 0; v < frame.height; ++v)
      std::memcpy(picture.gray16.pixel(0, v), frame.data[0] + std::ptrdiff_t{frame.linesize[0]} * v,
                  sizeof(std::uint16_t) * static_cast<std::size_t>(frame.width));
    if (frame.format == AV_PIX_FMT_GRAY16BE)
      for (std::uint16_t& value : picture.gray16.values()) value = static_cast<std::uint16_t>(value << 8 | value >> 8);
    picture.gray16 = turned(std::move(picture.gray16), stream_.quarter_turns);
    return picture;
  }
  const auto format = static_cast<AVPixelFormat>(frame.format);
  scaler_.reset(sws_getCachedContext(
      scaler_.release(), frame.width, frame.height, format, frame.width, frame.height, AV_PIX_FMT_RGB24,
      SWS_BILINEAR | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INT | SWS_BITEXACT, nullptr, nullptr, nullptr));
  if (!scaler_) fail("its pixels are of a kind that is not read");
  constexpr int kHdLines = 720; // from there on pictures that do not say it are BT.709
  const bool unsaid = frame.colorspace == AVCOL_SPC_UNSPECIFIED;
  const int space = unsaid ? (frame.height >= kHdLines ? SWS_CS_ITU709 : SWS_CS_ITU601) : frame.colorspace;
  const int full = frame.color_range == AVCOL_RANGE_JPEG ? 1 : 0;
  sws_setColorspaceDetails(scaler_.get(), sws_getCoefficients(space), full, sws_getCoefficients(SWS_CS_DEFAULT), 1, 0,
                           1 << 16, 1 << 16);
  picture.color = ColorImage(frame.width, frame.height, 3);
  std::uint8_t* const rows[4] = {picture.color.data()};
  const int strides[4] = {3 * frame.width};
  sws_scale(scaler_.get(), frame.data, frame.linesize, 0, frame.height, rows, strides);
  picture.color = turned(std::move(picture.color), stream_.quarter_turns);
  return picture;
}

} // namespace kinora::formats
