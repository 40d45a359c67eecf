// Telling a folder of OpenEXR frames without the OpenEXR library.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "kinora/plugin.h"

namespace kinora::formats {

/// The .exr files of a folder, in the order of the numbers in their names; empty if there is no such folder.
std::vector<std::filesystem::path> exr_files(const std::filesystem::path& folder);

/// The channels of a file's first part, by a walk through all of its header, every attribute of which lies within it:
/// the library believes their sizes. Throws Error(kCorruptInput), naming the path, if that is not so, or the header is
/// longer than 1 MiB.
std::vector<std::string> exr_channel_names(const std::filesystem::path& path);

/// As the plugin interface's `probe`, but that it may throw Error: a folder whose first file has colour and depth.
void probe_exr_sequence(const char* path, KinoraProbe* answer);

} // namespace kinora::formats
