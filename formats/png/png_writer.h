// Pictures as PNG files: a folder of them, or a single one.
#pragma once

#include <filesystem>
#include <string>

#include "kinora/plugin.h"

namespace kinora::formats {

/// Colour goes to <name>.png (8 bits, 3 channels or 4 with straight alpha), depth to <name>.depth.png (16 bits,
/// millimetres). A single picture goes to the path itself, its depth beside it: a.png and a.depth.png, or a.png.part
/// and a.depth.png.part. Every file is complete once `write` returns.
class PngWriter {
public:
  enum class Layout { kFolder, kFile };

  /// "auto" is a file if the path ends in .png or .png.part, else a folder.
  static Layout layout_of(const std::string& option, const std::filesystem::path& path);

  /// Makes the folder, or checks that the file can be written. Throws Error(kUnwritableOutput).
  PngWriter(std::filesystem::path path, Layout layout);

  /// Throws Error: kUnwritableOutput; kUsage for a second picture in a file or a name that leaves the folder.
  void write(const KinoraPicture& picture);
  /// Throws Error(kFailure) if a file was promised and no picture came.
  void finish() const;

private:
  std::filesystem::path path_;
  Layout layout_;
  int written_ = 0;
};

} // namespace kinora::formats
