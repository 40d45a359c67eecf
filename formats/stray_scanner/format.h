// Stray Scanner's folders as captures, for the table of built-in formats.
#pragma once

#include "kinora/plugin.h"

namespace kinora::formats {

extern const KinoraFormat kStrayFormat; ///< stray-scanner

} // namespace kinora::formats
