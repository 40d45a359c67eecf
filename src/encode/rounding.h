// Numbers as reports write them.
#pragma once

#include <cmath>

namespace kinora::encode {

/// To four places after the point.
inline double round4(double value) { return std::round(value * 1e4) / 1e4; }

/// PSNR of a mean of ‖C − C*‖², to hundredths of a decibel.
inline double psnr(double error) { return std::round(-1000 * std::log10(std::fmax(error, 1e-12) / 3)) / 100; }

} // namespace kinora::encode
