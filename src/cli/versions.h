// What this program was built from.
#pragma once

#include <string>

namespace kinora::cli {

/// "kinora 0.1.0" and one line for each library with its version.
std::string version_text();

} // namespace kinora::cli
