// Text files, packed with gzip or not.
#pragma once

#include <filesystem>
#include <string>

namespace kinora::simulator {

/// All of it. Throws Error(kCorruptInput), naming it, if it cannot be read.
std::string read_text_file(const std::filesystem::path& path);

/// Packed; the same text gives the same bytes. Throws Error(kUnwritableOutput).
void write_packed_text(const std::filesystem::path& path, const std::string& text);

} // namespace kinora::simulator
