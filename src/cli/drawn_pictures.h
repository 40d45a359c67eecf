// Pictures of a film that have been drawn, kept in a folder until the film is whole: who is interrupted need not draw
// them again.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>

#include "core/image.h"

namespace kinora::cli {

/// Not thread-safe. Throws Error(kUnwritableOutput).
class DrawnPictures {
public:
  /// The folder is made when there is a picture to be kept.
  explicit DrawnPictures(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// Picture `index` of those drawn from what `key` is a checksum of; nothing if it is not there, or not whole.
  std::optional<ColorImage> find(std::size_t index, std::uint32_t key);
  void keep(std::size_t index, std::uint32_t key, const ColorImage& picture);
  /// Those that were found or kept, and the folder unless there is something else in it.
  void remove();

private:
  std::filesystem::path path_of(std::size_t index, std::uint32_t key) const;

  std::filesystem::path folder_;
  std::set<std::filesystem::path> ours_;
};

} // namespace kinora::cli
