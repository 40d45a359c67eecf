// Surfaces and points as PLY files, for the table of built-in formats.
#pragma once

#include "kinora/plugin.h"

namespace kinora::formats {

extern const KinoraFormat kPlyFormat;

} // namespace kinora::formats
