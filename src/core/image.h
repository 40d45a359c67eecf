// Dense images in row-major order with interleaved channels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kinora {

/// height × width × channels values of T. Copying copies the pixels. Pixel (u, v) is column u, row v.
template <class T> class Image {
public:
  using Value = T;

  Image() = default;
  Image(int width, int height, int channels = 1, T fill = T{})
      : width_(width), height_(height), channels_(channels),
        values_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * static_cast<std::size_t>(channels),
                fill) {}

  int width() const { return width_; }
  int height() const { return height_; }
  int channels() const { return channels_; }
  bool empty() const { return values_.empty(); }
  std::size_t pixel_count() const { return static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_); }
  bool contains(int u, int v) const { return u >= 0 && v >= 0 && u < width_ && v < height_; }
  template <class U> bool same_size(const Image<U>& other) const {
    return width_ == other.width() && height_ == other.height();
  }

  T& at(int u, int v, int channel = 0) { return values_[index(u, v, channel)]; }
  const T& at(int u, int v, int channel = 0) const { return values_[index(u, v, channel)]; }
  T* pixel(int u, int v) { return values_.data() + index(u, v, 0); }
  const T* pixel(int u, int v) const { return values_.data() + index(u, v, 0); }

  std::span<T> values() { return values_; }
  std::span<const T> values() const { return values_; }
  T* data() { return values_.data(); }
  const T* data() const { return values_.data(); }

private:
  std::size_t index(int u, int v, int channel) const {
    return (static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(u)) *
               static_cast<std::size_t>(channels_) +
           static_cast<std::size_t>(channel);
  }

  int width_ = 0;
  int height_ = 0;
  int channels_ = 0;
  std::vector<T> values_;
};

using ColorImage = Image<std::uint8_t>;    ///< 3 channels sRGB, or 4 with straight alpha
using DepthImage = Image<float>;           ///< metres along the optical axis, 0 = nothing measured
using DepthImage16 = Image<std::uint16_t>; ///< a sensor's units (normally millimetres), 0 = nothing measured
using LabelImage = Image<std::uint8_t>;    ///< 0 background, 1 person, 2 object, 3… further objects

} // namespace kinora
