// Numbers as reports write them.
#pragma once

#include <cmath>

namespace kinora::encode {

/// To four places after the point.
inline double round4(double value) { return std::round(value * 1e4) / 1e4; }

} // namespace kinora::encode
