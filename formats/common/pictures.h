// Images of the plugin interface as images of the core.
#pragma once

#include "core/image.h"
#include "kinora/plugin.h"

namespace kinora::formats {

/// A copy. Throws Error(kUsage) unless it is 8-bit with 3 or 4 channels.
ColorImage color_of(const KinoraImage& image);

/// A copy. Throws Error(kUsage) unless it is 16-bit with one channel.
DepthImage16 depth_of(const KinoraImage& image);

/// A copy. Throws Error(kUsage) unless it is of floats with three channels.
Image<float> normal_of(const KinoraImage& image);

/// A copy. Throws Error(kUsage) unless it is of floats with one channel.
Image<float> metric_depth_of(const KinoraImage& image);

/// A copy. Throws Error(kUsage) unless it is 8-bit with one channel.
Image<std::uint8_t> confidence_of(const KinoraImage& image);
LabelImage labels_of(const KinoraImage& image);

} // namespace kinora::formats
