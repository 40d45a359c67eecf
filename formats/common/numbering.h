// The number in an image's name, and the images of a folder by number.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace kinora::formats {

/// "000012" → 12, "color_000012" → 12, "000012_shirt" → 12, "frame-000012.color" → 12: the number before the first
/// '_' if the name starts with one, else the last run of digits. Nothing if there is no digit, or more than 18.
std::optional<std::int64_t> number_in_name(const std::string& stem);

using NumberedFiles = std::map<std::int64_t, std::filesystem::path>;

/// Images of a folder by the number in their names. A second image with the same number is left out with a warning.
NumberedFiles number_images(const std::filesystem::path& folder, std::vector<std::string>& warnings);

/// The masks of a capture: images in `mask/` or `masks/`, by name and by number. Several images with one number are
/// masks of several things in one frame.
class MaskIndex {
public:
  explicit MaskIndex(const std::filesystem::path& folder);
  bool empty() const { return by_number_.empty() && by_stem_.empty(); }
  /// The masks of the frame whose colour image has this name: those with the same stem, else with the same number.
  std::vector<std::filesystem::path> masks_of(const std::filesystem::path& color) const;

private:
  std::map<std::string, std::filesystem::path> by_stem_;
  std::map<std::int64_t, std::vector<std::filesystem::path>> by_number_;
};

} // namespace kinora::formats
