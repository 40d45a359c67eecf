// Where the files of pictures go: into a folder, each under its name, or a single one to the path itself.
#pragma once

#include <filesystem>
#include <string>

namespace kinora::formats {

class PictureFiles {
public:
  enum class Layout { kFolder, kFile };

  /// "folder", "file", or "auto": a file if the path ends in `extension` (".png") or in it and ".part", else a folder.
  static Layout layout_of(const std::string& option, const std::filesystem::path& path, const std::string& extension);

  /// Makes the folder, or checks that the file can be written. Throws Error(kUnwritableOutput).
  PictureFiles(std::filesystem::path path, Layout layout, std::string extension);

  /// The file of the next picture; its folder exists. Throws Error: kUnwritableOutput; kUsage for a second picture in
  /// a file or a name that leaves the folder.
  std::filesystem::path next(const std::string& name);
  /// Throws Error(kFailure) if a file was promised and no picture came.
  void finish() const;

private:
  std::filesystem::path path_;
  Layout layout_;
  std::string extension_;
  int count_ = 0;
};

/// Makes a folder and those above it. Throws Error(kUnwritableOutput).
void make_folder(const std::filesystem::path& folder);

/// The path inside the folder that a picture's name asks for, without an extension. Throws Error(kUsage) if it leaves
/// the folder.
std::filesystem::path path_inside(const std::filesystem::path& folder, const std::string& name);

/// a.png.part → a.png
std::filesystem::path without_part(const std::filesystem::path& path);

/// a.png, ".depth.png" → a.depth.png; a.png.part → a.depth.png.part
std::filesystem::path path_beside(const std::filesystem::path& path, const std::string& extension);

} // namespace kinora::formats
