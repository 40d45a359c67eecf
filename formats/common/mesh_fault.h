// What a writer must not be given.
#pragma once

#include <string>

#include "kinora/plugin.h"

namespace kinora::formats {

/// What is wrong with a mesh; empty if nothing.
std::string fault_of(const KinoraMesh& mesh);

/// The same for formats of one time whose vertices have normals and colours.
std::string fault_of_colored(const KinoraMesh& mesh);

} // namespace kinora::formats
