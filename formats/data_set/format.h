// Data sets with transforms.json, for the table of built-in formats.
#pragma once

#include "kinora/plugin.h"

namespace kinora::formats {

extern const KinoraFormat kDataSetFormat;

} // namespace kinora::formats
