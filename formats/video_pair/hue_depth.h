// Depth that is shown as hue, as depth cameras' tools and Depthkit put it into ordinary videos.
#pragma once

#include "core/image.h"

namespace kinora::formats {

/// Hue 0 (red) is `near`, and going through yellow, green, blue and magenta back to red it grows evenly to `far`.
struct HueRange {
  double near = 0.3; ///< metres
  double far = 6;
};

inline constexpr double kHueDepthUnit = 0.0005; ///< metres: a hue has some 1500 steps

/// In units of kHueDepthUnit; 0 where a pixel is too dark or too grey to have a hue: nothing was measured there.
DepthImage16 depth_of_hue(const ColorImage& image, const HueRange& range);

} // namespace kinora::formats
