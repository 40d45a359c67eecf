// The module ffv1: libavcodec's FFV1 behind lossless_video.h.
#include <cstring>
#include <string>

#include "libav/libav.h"
#include "recording/lossless_video.h"

extern "C" {
#include <libavutil/opt.h>
}

namespace kinora::recording {
namespace {

using libav::check;

/// RGB is stored as FFV1 does it best: by its reversible colour transform, from four bytes a pixel.
AVPixelFormat pixel_format(PixelLayout layout) {
  return layout == PixelLayout::kRgb8     ? AV_PIX_FMT_0RGB32
         : layout == PixelLayout::kGray16 ? AV_PIX_FMT_GRAY16
                                          : AV_PIX_FMT_GRAY8;
}

libav::Codec context_of(const AVCodec* codec, const PictureShape& shape) {
  libav::Codec context = libav::make_codec(
      codec, "libavcodec was built without FFV1, which recordings need; install another build of FFmpeg");
  context->width = shape.width;
  context->height = shape.height;
  context->pix_fmt = pixel_format(shape.layout);
  context->thread_count = 1; // streams are encoded beside each other
  context->flags |= AV_CODEC_FLAG_BITEXACT;
  return context;
}

class Ffv1Encoder final : public LosslessEncoder {
public:
  explicit Ffv1Encoder(const PictureShape& shape)
      : shape_(shape), context_(context_of(avcodec_find_encoder(AV_CODEC_ID_FFV1), shape)), frame_(av_frame_alloc()),
        packet_(av_packet_alloc()) {
    context_->time_base = {1, 1000};
    context_->level = 3;
    context_->gop_size = 1; // every picture is read without others
    av_opt_set_int(context_->priv_data, "slicecrc", 1, 0);
    check(avcodec_open2(context_.get(), context_->codec, nullptr), ErrorCode::kFailure, "FFV1 cannot be started");
    frame_->format = context_->pix_fmt;
    frame_->width = shape.width;
    frame_->height = shape.height;
    check(av_frame_get_buffer(frame_.get(), 0), ErrorCode::kFailure, "a picture has no room");
  }

  std::vector<std::byte> private_data() const override {
    const auto* data = reinterpret_cast<const std::byte*>(context_->extradata);
    return {data, data + context_->extradata_size};
  }

  std::vector<std::byte> encode(const void* pixels, std::size_t row_bytes) override {
    check(av_frame_make_writable(frame_.get()), ErrorCode::kFailure, "a picture has no room");
    for (int v = 0; v < shape_.height; ++v) fill_row(static_cast<const std::byte*>(pixels) + row_bytes * v, v);
    frame_->pts = count_++;
    check(avcodec_send_frame(context_.get(), frame_.get()), ErrorCode::kFailure, "FFV1 cannot encode");
    check(avcodec_receive_packet(context_.get(), packet_.get()), ErrorCode::kFailure, "FFV1 cannot encode");
    const auto* data = reinterpret_cast<const std::byte*>(packet_->data);
    std::vector<std::byte> bytes(data, data + packet_->size);
    av_packet_unref(packet_.get());
    return bytes;
  }

private:
  void fill_row(const std::byte* from, int v) {
    std::uint8_t* to = frame_->data[0] + static_cast<std::ptrdiff_t>(frame_->linesize[0]) * v;
    if (shape_.layout != PixelLayout::kRgb8) {
      std::memcpy(to, from, bytes_per_pixel(shape_.layout) * static_cast<std::size_t>(shape_.width));
      return;
    }
    for (int u = 0; u < shape_.width; ++u) {
      const std::uint32_t value = std::to_integer<std::uint32_t>(from[3 * u]) << 16 |
                                  std::to_integer<std::uint32_t>(from[3 * u + 1]) << 8 |
                                  std::to_integer<std::uint32_t>(from[3 * u + 2]);
      std::memcpy(to + 4 * u, &value, sizeof value);
    }
  }

  PictureShape shape_;
  libav::Codec context_;
  libav::Frame frame_;
  libav::Packet packet_;
  std::int64_t count_ = 0;
};

class Ffv1Decoder final : public LosslessDecoder {
public:
  Ffv1Decoder(const PictureShape& shape, std::span<const std::byte> private_data)
      : shape_(shape), context_(context_of(avcodec_find_decoder(AV_CODEC_ID_FFV1), shape)), frame_(av_frame_alloc()),
        packet_(av_packet_alloc()) {
    if (private_data.empty()) throw Error(ErrorCode::kCorruptInput, "an FFV1 track has no description");
    context_->err_recognition = AV_EF_CRCCHECK | AV_EF_EXPLODE;
    libav::set_private_data(*context_, private_data);
    check(avcodec_open2(context_.get(), context_->codec, nullptr), ErrorCode::kCorruptInput,
          "the description of an FFV1 track cannot be understood");
  }

  std::vector<std::byte> decode(std::span<const std::byte> bytes) override {
    if (bytes.empty())
      throw Error(ErrorCode::kCorruptInput, "an FFV1 picture has no bytes"); // else it would end the track
    libav::fill(*packet_, bytes);
    int result = avcodec_send_packet(context_.get(), packet_.get());
    av_packet_unref(packet_.get());
    if (result >= 0) result = avcodec_receive_frame(context_.get(), frame_.get());
    check(result, ErrorCode::kCorruptInput, "an FFV1 picture is damaged");
    if (frame_->width != shape_.width || frame_->height != shape_.height ||
        frame_->format != pixel_format(shape_.layout) || frame_->decode_error_flags != 0)
      throw Error(ErrorCode::kCorruptInput, "an FFV1 picture is damaged or of another size");
    return pixels();
  }

private:
  std::vector<std::byte> pixels() const {
    const std::size_t row_bytes = bytes_per_pixel(shape_.layout) * static_cast<std::size_t>(shape_.width);
    std::vector<std::byte> out(row_bytes * static_cast<std::size_t>(shape_.height));
    for (int v = 0; v < shape_.height; ++v) {
      const std::uint8_t* from = frame_->data[0] + static_cast<std::ptrdiff_t>(frame_->linesize[0]) * v;
      std::byte* to = out.data() + row_bytes * static_cast<std::size_t>(v);
      if (shape_.layout != PixelLayout::kRgb8) {
        std::memcpy(to, from, row_bytes);
        continue;
      }
      for (int u = 0; u < shape_.width; ++u) {
        std::uint32_t value = 0;
        std::memcpy(&value, from + 4 * u, sizeof value);
        for (int channel = 0; channel < 3; ++channel)
          to[3 * u + channel] = static_cast<std::byte>(value >> (16 - 8 * channel) & 0xFF);
      }
    }
    return out;
  }

  PictureShape shape_;
  libav::Codec context_;
  libav::Frame frame_;
  libav::Packet packet_;
};

const LosslessModule kModule = {
    [](const PictureShape& shape) -> std::unique_ptr<LosslessEncoder> { return std::make_unique<Ffv1Encoder>(shape); },
    [](const PictureShape& shape, std::span<const std::byte> private_data) -> std::unique_ptr<LosslessDecoder> {
      return std::make_unique<Ffv1Decoder>(shape, private_data);
    }};

} // namespace
} // namespace kinora::recording

extern "C" const kinora::recording::LosslessModule* kinora_functions() { return &kinora::recording::kModule; }
