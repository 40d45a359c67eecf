// Pictures to FFV1 (RFC 9043, version 3) and back, bit by bit: every picture for itself, checksums in every slice.
// FFmpeg's libavcodec does it, in a module (core/module.h) that is opened on first use.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace kinora::recording {

/// Values of a picture: RGB, or grey of 8 or 16 bits.
enum class PixelLayout { kRgb8, kGray8, kGray16 };

constexpr std::size_t bytes_per_pixel(PixelLayout layout) {
  return layout == PixelLayout::kRgb8 ? 3 : layout == PixelLayout::kGray16 ? 2 : 1;
}

struct PictureShape {
  int width = 0;
  int height = 0;
  PixelLayout layout = PixelLayout::kGray8;
  bool operator==(const PictureShape&) const = default;
};

/// Not thread-safe; different ones may be used at the same time.
class LosslessEncoder {
public:
  virtual ~LosslessEncoder() = default;
  /// What the decoder needs beforehand: CodecPrivate of the track.
  virtual std::vector<std::byte> private_data() const = 0;
  /// `pixels`: rows from the top, `row_bytes` apart. The same picture gives the same bytes. Throws Error(kFailure).
  virtual std::vector<std::byte> encode(const void* pixels, std::size_t row_bytes) = 0;
};

/// Not thread-safe; different ones may be used at the same time.
class LosslessDecoder {
public:
  virtual ~LosslessDecoder() = default;
  /// The pixels, rows without gaps. Throws Error(kCorruptInput) if the bytes are damaged or of another shape.
  virtual std::vector<std::byte> decode(std::span<const std::byte> bytes) = 0;
};

/// Throw Error(kMissingComponent) if the module is not installed, kFailure if libavcodec has no FFV1.
std::unique_ptr<LosslessEncoder> make_ffv1_encoder(const PictureShape& shape);
std::unique_ptr<LosslessDecoder> make_ffv1_decoder(const PictureShape& shape, std::span<const std::byte> private_data);

/// What the module exports: kinora_functions() returns one.
struct LosslessModule {
  std::unique_ptr<LosslessEncoder> (*make_encoder)(const PictureShape& shape);
  std::unique_ptr<LosslessDecoder> (*make_decoder)(const PictureShape& shape, std::span<const std::byte> private_data);
};

} // namespace kinora::recording
