// What drawing does with the colour net's outputs, vectorised with Highway.
#pragma once

#include <cstddef>

#include "fields/model/field.h"

namespace kinora::fields::kernels {

/// colors (n × 4): sRGB out of outputs (n × kColorOutputs) by the sigmoid, then a number that means nothing.
void to_colors(const float* outputs, std::size_t n, float* colors);

} // namespace kinora::fields::kernels
