// Pictures turned by right angles.
#pragma once

#include <algorithm>

#include "core/image.h"

namespace kinora::formats {

/// Clockwise by 0 to 3 quarters of a turn.
template <class T> Image<T> turned(Image<T> image, int quarter_turns) {
  if (quarter_turns == 0) return image;
  const int width = image.width();
  const int height = image.height();
  const bool upright = quarter_turns == 2;
  Image<T> out(upright ? width : height, upright ? height : width, image.channels());
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const T* from = image.pixel(u, v);
      T* const to = quarter_turns == 1   ? out.pixel(height - 1 - v, u)
                    : quarter_turns == 2 ? out.pixel(width - 1 - u, height - 1 - v)
                                         : out.pixel(v, width - 1 - u);
      std::copy_n(from, image.channels(), to);
    }
  }
  return out;
}

} // namespace kinora::formats
