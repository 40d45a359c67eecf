// Where the picture moves between two frames.
#pragma once

#include <algorithm>

#include "core/image.h"

namespace kinora::ingest {

/// For each pixel of `to` the offset (du, dv), in pixels, to where the same point is in `from`: dense inverse search
/// (Kroeger et al., 2016) through OpenCV. Both sRGB, 3 channels, of one size. The same bits for any number of threads.
/// Not thread-safe: it changes OpenCV's number of threads for its own time.
Image<float> optical_flow(const ColorImage& to, const ColorImage& from);

/// The pixel of `from` that pixel (u, v) of `to` comes from; may lie outside.
struct Pixel {
  int u, v;
};
Pixel origin_of(const Image<float>& flow, int u, int v);

/// An image of `from` as it would be in `to`: each pixel takes the value where it comes from, or 0.
template <class T> Image<T> warped(const Image<T>& image, const Image<float>& flow) {
  Image<T> result(image.width(), image.height(), image.channels());
  for (int v = 0; v < image.height(); ++v) {
    for (int u = 0; u < image.width(); ++u) {
      const Pixel origin = origin_of(flow, u, v);
      if (image.contains(origin.u, origin.v))
        std::copy_n(image.pixel(origin.u, origin.v), image.channels(), result.pixel(u, v));
    }
  }
  return result;
}

} // namespace kinora::ingest
