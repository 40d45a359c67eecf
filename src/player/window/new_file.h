// Files that are new for certain: what is there already is never touched.
#pragma once

#include <filesystem>
#include <span>
#include <string>

namespace kinora::player::window {

/// Writes NAME+EXTENSION in `folder`, or NAME-2+EXTENSION and so on where there is something of that name, and returns
/// its path. Throws Error(kUnwritableOutput); nothing is left half-written.
std::filesystem::path write_new_file(const std::filesystem::path& folder, const std::string& name,
                                     const std::string& extension, std::span<const std::byte> bytes);

} // namespace kinora::player::window
