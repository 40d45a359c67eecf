// Our images as OpenCV's, without a copy.
#pragma once

#include <opencv2/core.hpp>

#include "core/image.h"

namespace kinora::ingest {

/// Of an image that must live longer and is not written to: OpenCV has no read-only header.
inline cv::Mat view_of(const Image<std::uint8_t>& image) {
  return {image.height(), image.width(), CV_8UC(image.channels()), const_cast<std::uint8_t*>(image.data())};
}

} // namespace kinora::ingest
