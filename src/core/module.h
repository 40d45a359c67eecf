// Modules: shared libraries of Kinora's own, each around a large foreign library that few commands need. A module is
// opened when it is first used, so that nobody else waits for it.
#pragma once

#include <filesystem>
#include <string>

namespace kinora {

/// lib/kinora beside the folder of the running program, in build trees and in installations; empty if the system does
/// not say where that program is.
std::filesystem::path module_folder();

/// NAME.so in that folder.
std::filesystem::path module_path(const std::string& name);

/// What a module exports as `symbol`. The module stays open. `purpose` says in an error what the module is needed for:
/// "to write MP4 films". Thread-safe. Throws Error(kMissingComponent) if the module, or a library that it needs, is not
/// installed.
void* module_symbol(const std::string& name, const char* symbol, const std::string& purpose);

} // namespace kinora
