// USD text, for the table of built-in formats.
#pragma once

#include "kinora/plugin.h"

namespace kinora::formats {

extern const KinoraFormat kUsdFormat;

} // namespace kinora::formats
