#include "text_file.h"

#include <array>
#include <memory>

#include <zlib.h>

#include "core/error.h"

namespace kinora::simulator {

std::string read_text_file(const std::filesystem::path& path) {
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> file(gzopen(path.c_str(), "rb"), gzclose);
  std::string text;
  std::array<char, 1 << 16> part{};
  int got = 0;
  while (file && (got = gzread(file.get(), part.data(), part.size())) > 0)
    text.append(part.data(), static_cast<std::size_t>(got));
  if (!file || got < 0 || text.empty())
    throw Error(ErrorCode::kCorruptInput, path.string() + ": missing, empty or damaged");
  return text;
}

void write_packed_text(const std::filesystem::path& path, const std::string& text) {
  const gzFile file = gzopen(path.c_str(), "wb9");
  const bool written = file != nullptr && gzwrite(file, text.data(), static_cast<unsigned>(text.size())) > 0;
  if (file == nullptr || gzclose(file) != Z_OK || !written)
    throw Error(ErrorCode::kUnwritableOutput, path.string() + ": cannot be written");
}

} // namespace kinora::simulator
