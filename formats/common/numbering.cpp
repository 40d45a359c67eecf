#include "common/numbering.h"

#include <charconv>

#include "common/files.h"

namespace kinora::formats {
namespace fs = std::filesystem;

namespace {

constexpr const char* kDigits = "0123456789";
constexpr std::size_t kMaxDigits = 18;

} // namespace

std::optional<std::int64_t> number_in_name(const std::string& stem) {
  std::size_t begin = 0;
  std::size_t end = stem.find_first_not_of(kDigits);
  if (end == 0 || end == std::string::npos || stem[end] != '_') {
    const std::size_t last = stem.find_last_of(kDigits);
    if (last == std::string::npos) return std::nullopt;
    end = last + 1;
    const std::size_t before = stem.find_last_not_of(kDigits, last);
    begin = before == std::string::npos ? 0 : before + 1;
  }
  if (end - begin > kMaxDigits) return std::nullopt;
  std::int64_t number = 0;
  std::from_chars(stem.data() + begin, stem.data() + end, number);
  return number;
}

NumberedFiles number_images(const fs::path& folder, std::vector<std::string>& warnings) {
  NumberedFiles files;
  for (const fs::path& path : list_files(folder)) {
    if (!is_image_name(path)) continue;
    const std::optional<std::int64_t> number = number_in_name(path.stem().string());
    if (!number) continue;
    const auto [entry, is_new] = files.emplace(*number, path);
    if (!is_new)
      warnings.push_back(path.string() + ": left out, for " + entry->second.filename().string() +
                         " has the same number");
  }
  return files;
}

MaskIndex::MaskIndex(const fs::path& folder) {
  for (const char* name : {"mask", "masks"}) {
    for (const fs::path& path : list_files(folder / name)) {
      if (!is_image_name(path)) continue;
      const std::string stem = path.stem().string();
      by_stem_.emplace(stem, path);
      if (const auto number = number_in_name(stem)) by_number_[*number].push_back(path);
    }
  }
}

std::vector<fs::path> MaskIndex::masks_of(const fs::path& color) const {
  const std::string stem = color.stem().string();
  if (const auto found = by_stem_.find(stem); found != by_stem_.end()) return {found->second};
  if (const auto number = number_in_name(stem))
    if (const auto found = by_number_.find(*number); found != by_number_.end()) return found->second;
  return {};
}

} // namespace kinora::formats
