// Images as the plugin interface has them.
#pragma once

#include "core/image.h"
#include "kinora/plugin.h"

namespace kinora::host {

/// Points to the image's pixels; no image if it is empty.
template <class T> KinoraImage view_of(const Image<T>& image, KinoraPixelType type) {
  KinoraImage view{};
  if (image.empty()) return view;
  view.width = image.width();
  view.height = image.height();
  view.channels = image.channels();
  view.pixel_type = type;
  view.row_bytes = sizeof(T) * static_cast<std::size_t>(image.width()) * static_cast<std::size_t>(image.channels());
  view.data = image.data();
  return view;
}

} // namespace kinora::host
