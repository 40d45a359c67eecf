// What a colour and depth camera makes of light and of true depth: noise, holes and flying pixels.
#pragma once

#include "core/image.h"
#include "core/random.h"

namespace kinora::tracking::testing {

/// Depth in metres, 0: nothing is measured there. Noise of sensor_noise.h in whole millimetres; half of what lies
/// beside a jump is lost and a fifth of it flies. The outermost pixels are lost.
DepthImage measured(const DepthImage& truth, Random& random);

/// sRGB of linear light (three channels), with noise.
ColorImage exposed(const Image<float>& light, Random& random);

} // namespace kinora::tracking::testing
