#include "player/window/new_file.h"

#include <cerrno>
#include <cstdio>
#include <cstring>

#include <fmt/format.h>

#include "core/error.h"

namespace kinora::player::window {

std::filesystem::path write_new_file(const std::filesystem::path& folder, const std::string& name,
                                     const std::string& extension, std::span<const std::byte> bytes) {
  constexpr int kTries = 100000;
  for (int i = 1; i < kTries; ++i) {
    std::filesystem::path path = folder / (i == 1 ? name + extension : fmt::format("{}-{}{}", name, i, extension));
    std::FILE* file = std::fopen(path.c_str(), "wbx");
    if (file == nullptr && errno == EEXIST) continue;
    if (file == nullptr) {
      throw Error(ErrorCode::kUnwritableOutput, fmt::format("{} cannot be written: {}; start from a folder of yours",
                                                            path.string(), std::strerror(errno)));
    }
    const bool written = std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
    if (std::fclose(file) == 0 && written) return path;
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
    throw Error(ErrorCode::kUnwritableOutput,
                fmt::format("{} cannot be written to its end; is the disk full?", path.string()));
  }
  throw Error(ErrorCode::kUnwritableOutput,
              fmt::format("{} holds too many files named {}; start from another folder", folder.string(), name));
}

} // namespace kinora::player::window
