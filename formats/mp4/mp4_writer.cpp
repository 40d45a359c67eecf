#include "mp4/mp4_writer.h"

#include <algorithm>
#include <vector>

#include "core/error.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/opt.h>
#include <libswscale/swscale.h>
}

namespace kinora::formats {
namespace {

constexpr AVRational kTimeBase = {1, 60000}; ///< whole ticks for 24, 25, 30, 50, 60 and 29.97 frames per second
constexpr int kLastQuality = 51;             ///< the worst, of H.264 and of the option
constexpr int kLastVp9Quality = 63;
constexpr double kLongestJump = 3600; ///< seconds
constexpr int kVp9Speed = 4;          ///< of 0 (slow) to 8
constexpr int kMpeg4Quality = 3;      ///< quantiser of the encoder that has no constant quality

template <class T, void (*release)(T**)> struct Release {
  void operator()(T* handle) const { release(&handle); }
};
using CodecContext = std::unique_ptr<AVCodecContext, Release<AVCodecContext, avcodec_free_context>>;
using AvFrame = std::unique_ptr<AVFrame, Release<AVFrame, av_frame_free>>;
using AvPacket = std::unique_ptr<AVPacket, Release<AVPacket, av_packet_free>>;

struct ReleaseOutput {
  void operator()(AVFormatContext* context) const {
    if (context->pb != nullptr) avio_closep(&context->pb);
    avformat_free_context(context);
  }
};
struct ReleaseScaler {
  void operator()(SwsContext* scaler) const { sws_freeContext(scaler); }
};

std::string text_of(int error) {
  char text[AV_ERROR_MAX_STRING_SIZE] = {};
  av_strerror(error, text, sizeof text);
  return text;
}

/// "a.webm", also with ".part" or ".2.part" behind it, as files are called that are not whole yet.
bool is_webm(std::filesystem::path path) {
  const auto is_number = [](const std::string& text) {
    return text.size() > 1 && std::all_of(text.begin() + 1, text.end(), [](char c) { return c >= '0' && c <= '9'; });
  };
  while (path.extension() == ".part" || is_number(path.extension().string())) path.replace_extension();
  return path.extension() == ".webm";
}

const AVCodec& find_encoder(bool webm) {
  if (webm) {
    const AVCodec* codec = avcodec_find_encoder_by_name("libvpx-vp9");
    if (codec == nullptr)
      throw Error(ErrorCode::kMissingComponent, "libavcodec has no encoder for WebM films; install one with libvpx, or "
                                                "write an MP4 film");
    return *codec;
  }
  const AVCodec* codec = avcodec_find_encoder_by_name("libx264");
  if (codec == nullptr) codec = avcodec_find_encoder(AV_CODEC_ID_MPEG4);
  if (codec == nullptr)
    throw Error(ErrorCode::kMissingComponent,
                "libavcodec has no encoder for MP4 films; install one with libx264, or write PNG pictures");
  return *codec;
}

} // namespace

class Mp4Writer::Film {
public:
  Film(const std::filesystem::path& path, const Mp4Settings& settings)
      : path_(path.string()), webm_(is_webm(path)), settings_(settings), packet_(av_packet_alloc()) {
    if (!(settings.frames_per_second > 0 && settings.frames_per_second <= 1000) || settings.crf < 0 ||
        settings.crf > kLastQuality)
      throw Error(ErrorCode::kUsage, "a film needs fps above 0 and up to 1000, and crf from 0 to 51");
    if (!(settings.jump_seconds >= 0 && settings.jump_seconds <= kLongestJump))
      throw Error(ErrorCode::kUsage, "a film needs jump from 0 to 3600 seconds");
    av_log_set_level(AV_LOG_QUIET); // a library does not print; failures come back as return values
    AVFormatContext* output = nullptr;
    check(avformat_alloc_output_context2(&output, nullptr, webm_ ? "webm" : "mp4", path_.c_str()));
    output_.reset(output);
    check(avio_open(&output_->pb, path_.c_str(), AVIO_FLAG_WRITE));
    output_->flags |= AVFMT_FLAG_BITEXACT;
  }

  /// A comment, which MP4 keeps among iTunes' tags and WebM among its own.
  void describe(const Facts& facts) {
    const std::string comment = "Kinora\n" + lines_of(facts, "");
    check(av_dict_set(&output_->metadata, "comment", comment.c_str(), 0));
  }

  void write(const KinoraPicture& picture) {
    const KinoraImage& color = picture.color;
    if (color.data == nullptr || color.pixel_type != KINORA_PIXEL_U8 || color.channels != 3 || color.width < 1 ||
        color.height < 1)
      throw Error(ErrorCode::kUsage, path_ + ": the pictures of a film must have 8 bits and 3 channels");
    if (!codec_) start(color, picture.time);
    if (color.width != width_ || color.height != height_)
      throw Error(ErrorCode::kUsage, path_ + ": all pictures of a film must have the same size");
    const std::int64_t ticks = std::llround((picture.time - start_time_) / av_q2d(kTimeBase));
    if (ticks <= last_ticks_) throw Error(ErrorCode::kUsage, path_ + ": the times of a film's pictures must increase");
    last_ticks_ = ticks;
    convert(color);
    frame_->pts = ticks;
    encode(frame_.get());
  }

  void finish() {
    if (!codec_) throw Error(ErrorCode::kFailure, path_ + ": a film needs at least one picture");
    encode(nullptr);
    check(av_write_trailer(output_.get()));
    check(output_->pb->error);
    check(avio_closep(&output_->pb));
  }

private:
  void check(int result) const {
    if (result < 0)
      throw Error(ErrorCode::kUnwritableOutput, path_ + ": the film cannot be written: " + text_of(result));
  }

  void start(const KinoraImage& color, double time) {
    width_ = color.width;
    height_ = color.height;
    start_time_ = time;
    const AVCodec& encoder = find_encoder(webm_);
    CodecContext codec(avcodec_alloc_context3(&encoder));
    codec->width = width_ + width_ % 2;
    codec->height = height_ + height_ % 2;
    codec->pix_fmt = AV_PIX_FMT_YUV420P;
    codec->time_base = kTimeBase;
    codec->framerate = av_d2q(settings_.frames_per_second, 60000);
    codec->color_range = AVCOL_RANGE_MPEG;
    codec->colorspace = AVCOL_SPC_BT709;
    codec->color_primaries = AVCOL_PRI_BT709;
    codec->color_trc = AVCOL_TRC_BT709;
    codec->thread_count = 1; // x264's bytes depend on the number of threads
    if (settings_.jump_seconds > 0) {
      const double pictures = settings_.jump_seconds * settings_.frames_per_second;
      codec->gop_size = std::max(1, static_cast<int>(std::lround(pictures)));
    }
    codec->flags |= AV_CODEC_FLAG_BITEXACT | AV_CODEC_FLAG_GLOBAL_HEADER;
    if (encoder.id == AV_CODEC_ID_MPEG4) {
      codec->flags |= AV_CODEC_FLAG_QSCALE;
      codec->global_quality = FF_QP2LAMBDA * kMpeg4Quality;
    } else {
      check(av_opt_set_int(codec->priv_data, "crf",
                           webm_ ? settings_.crf * kLastVp9Quality / kLastQuality : settings_.crf, 0));
    }
    if (webm_) {
      codec->bit_rate = 0; // constant quality
      check(av_opt_set_int(codec->priv_data, "cpu-used", kVp9Speed, 0));
    }
    check(avcodec_open2(codec.get(), &encoder, nullptr));
    stream_ = avformat_new_stream(output_.get(), nullptr);
    stream_->time_base = kTimeBase;
    stream_->avg_frame_rate = codec->framerate;
    check(avcodec_parameters_from_context(stream_->codecpar, codec.get()));
    AVDictionary* options = nullptr;
    av_dict_set(&options, "movflags", "+faststart", 0);
    const int header = avformat_write_header(output_.get(), &options);
    av_dict_free(&options);
    check(header);
    make_frame(*codec);
    codec_ = std::move(codec);
  }

  void make_frame(const AVCodecContext& codec) {
    frame_.reset(av_frame_alloc());
    frame_->format = codec.pix_fmt;
    frame_->width = codec.width;
    frame_->height = codec.height;
    check(av_frame_get_buffer(frame_.get(), 0));
    scaler_.reset(sws_getContext(codec.width, codec.height, AV_PIX_FMT_RGB24, codec.width, codec.height, codec.pix_fmt,
                                 SWS_BILINEAR | SWS_ACCURATE_RND | SWS_BITEXACT, nullptr, nullptr, nullptr));
    if (!scaler_) throw Error(ErrorCode::kFailure, path_ + ": pictures of this size cannot be converted to video");
    const int* bt709 = sws_getCoefficients(SWS_CS_ITU709);
    sws_setColorspaceDetails(scaler_.get(), bt709, 1, bt709, 0, 0, 1 << 16, 1 << 16);
    even_.resize(std::size_t{3} * codec.width * codec.height);
  }

  /// RGB to YUV, with the last row and column repeated where the size is odd.
  void convert(const KinoraImage& color) {
    const std::size_t row_bytes = std::size_t{3} * frame_->width;
    for (int v = 0; v < frame_->height; ++v) {
      const auto* from = static_cast<const std::uint8_t*>(color.data) + color.row_bytes * std::min(v, height_ - 1);
      std::uint8_t* to = even_.data() + row_bytes * v;
      std::copy(from, from + std::size_t{3} * width_, to);
      if (frame_->width > width_) std::copy(from + 3 * (width_ - 1), from + 3 * width_, to + 3 * width_);
    }
    const std::uint8_t* planes[1] = {even_.data()};
    const int strides[1] = {static_cast<int>(row_bytes)};
    check(av_frame_make_writable(frame_.get()));
    sws_scale(scaler_.get(), planes, strides, 0, frame_->height, frame_->data, frame_->linesize);
  }

  /// Hands a frame to the encoder, or tells it that there are no more, and writes what comes out.
  void encode(const AVFrame* frame) {
    check(avcodec_send_frame(codec_.get(), frame));
    for (;;) {
      const int result = avcodec_receive_packet(codec_.get(), packet_.get());
      if (result == AVERROR(EAGAIN) || result == AVERROR_EOF) return;
      check(result);
      if (packet_->duration == 0)
        packet_->duration = std::llround(1.0 / (settings_.frames_per_second * av_q2d(kTimeBase)));
      av_packet_rescale_ts(packet_.get(), kTimeBase, stream_->time_base);
      packet_->stream_index = stream_->index;
      check(av_interleaved_write_frame(output_.get(), packet_.get()));
      check(output_->pb->error);
    }
  }

  std::string path_;
  bool webm_;
  Mp4Settings settings_;
  std::unique_ptr<AVFormatContext, ReleaseOutput> output_;
  CodecContext codec_;
  AvFrame frame_;
  AvPacket packet_;
  std::unique_ptr<SwsContext, ReleaseScaler> scaler_;
  std::vector<std::uint8_t> even_; ///< one picture of even size, RGB
  AVStream* stream_ = nullptr;     ///< owned by output_
  int width_ = 0;
  int height_ = 0;
  double start_time_ = 0;
  std::int64_t last_ticks_ = -1;
};

Mp4Writer::Mp4Writer(const std::filesystem::path& path, const Mp4Settings& settings)
    : film_(std::make_unique<Film>(path, settings)) {}
Mp4Writer::~Mp4Writer() = default;
void Mp4Writer::describe(const Facts& facts) { film_->describe(facts); }
void Mp4Writer::write(const KinoraPicture& picture) { film_->write(picture); }
void Mp4Writer::finish() { film_->finish(); }

} // namespace kinora::formats
