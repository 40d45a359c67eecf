#include "ingest/depth/undistortion.h"

#include "core/parallel.h"

namespace kinora::ingest {
namespace {

constexpr std::size_t kPixelsPerChunk = 16384;

/// Distorted coordinates for normalised ideal ones. Source: Brown 1971, as written in OpenCV's calib3d.
Eigen::Vector2d distort(const Distortion& d, double x, double y) {
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (d.k1 + r2 * (d.k2 + r2 * d.k3));
  return {x * radial + 2 * d.p1 * x * y + d.p2 * (r2 + 2 * x * x),
          y * radial + d.p1 * (r2 + 2 * y * y) + 2 * d.p2 * x * y};
}

} // namespace

Undistortion::Undistortion(const Intrinsics& k, const Distortion& distortion)
    : width_(k.width), height_(k.height), sources_(static_cast<std::size_t>(k.width) * k.height) {
  for (int v = 0; v < height_; ++v) {
    for (int u = 0; u < width_; ++u) {
      const Eigen::Vector2d p = distort(distortion, (u - k.cx) / k.fx, (v - k.cy) / k.fy);
      sources_[static_cast<std::size_t>(v) * width_ + u] = {static_cast<float>(k.fx * p.x() + k.cx),
                                                            static_cast<float>(k.fy * p.y() + k.cy)};
    }
  }
}

ColorImage Undistortion::color(const ColorImage& distorted) const {
  ColorImage ideal(width_, height_, distorted.channels());
  const int channels = distorted.channels();
  parallel_for(sources_.size(), kPixelsPerChunk, [&](const Chunk& chunk) {
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      const Source source = sources_[i];
      // Written so that NaN is outside too.
      if (!(source.u >= 0 && source.v >= 0 && source.u <= static_cast<float>(width_ - 1) &&
            source.v <= static_cast<float>(height_ - 1)))
        continue;
      const int u = std::min(static_cast<int>(source.u), std::max(width_ - 2, 0));
      const int v = std::min(static_cast<int>(source.v), std::max(height_ - 2, 0));
      const float a = source.u - static_cast<float>(u);
      const float b = source.v - static_cast<float>(v);
      const int u1 = std::min(u + 1, width_ - 1);
      const int v1 = std::min(v + 1, height_ - 1);
      for (int c = 0; c < channels; ++c) {
        const float top = (1 - a) * distorted.at(u, v, c) + a * distorted.at(u1, v, c);
        const float bottom = (1 - a) * distorted.at(u, v1, c) + a * distorted.at(u1, v1, c);
        ideal.data()[i * channels + c] = static_cast<std::uint8_t>(std::lround((1 - b) * top + b * bottom));
      }
    }
  });
  return ideal;
}

template <class T> Image<T> Undistortion::nearest(const Image<T>& distorted) const {
  Image<T> ideal(width_, height_);
  for (std::size_t i = 0; i < sources_.size(); ++i) {
    const float u = sources_[i].u + 0.5F;
    const float v = sources_[i].v + 0.5F;
    if (u >= 0 && v >= 0 && u < static_cast<float>(width_) && v < static_cast<float>(height_))
      ideal.data()[i] = distorted.at(static_cast<int>(u), static_cast<int>(v));
  }
  return ideal;
}

DepthImage Undistortion::depth(const DepthImage& distorted) const { return nearest(distorted); }
LabelImage Undistortion::labels(const LabelImage& distorted) const { return nearest(distorted); }

} // namespace kinora::ingest
