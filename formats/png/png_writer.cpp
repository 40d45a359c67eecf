#include "png/png_writer.h"

#include <algorithm>
#include <cmath>

#include "common/files.h"
#include "common/pictures.h"
#include "core/error.h"
#include "core/image_codec.h"

namespace kinora::formats {
namespace fs = std::filesystem;

namespace {

constexpr const char* kPartSuffix = ".part";

fs::path without_part(const fs::path& path) {
  return path.extension() == kPartSuffix ? fs::path(path).replace_extension() : path;
}

/// a.png → a.depth.png, a.png.part → a.depth.png.part
fs::path path_beside(const fs::path& color_path, const char* extension) {
  fs::path path = without_part(color_path);
  path.replace_extension(extension);
  if (path != color_path && color_path.extension() == kPartSuffix) path += kPartSuffix;
  return path;
}

/// Axes x right, y up, z towards the camera, as in tools for artists; −1 to 1 as 0 to 255. No normal is black.
ColorImage as_colors(const Image<float>& normals) {
  ColorImage colors(normals.width(), normals.height(), 3);
  for (std::size_t i = 0; i < normals.pixel_count(); ++i) {
    const float* n = normals.data() + 3 * i;
    if (n[0] == 0 && n[1] == 0 && n[2] == 0) continue;
    const float axes[] = {n[0], -n[1], -n[2]};
    for (std::size_t c = 0; c < 3; ++c) {
      colors.data()[3 * i + c] =
          static_cast<std::uint8_t>(std::lround(127.5F * (1 + std::clamp(axes[c], -1.0F, 1.0F))));
    }
  }
  return colors;
}

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error || !fs::is_directory(folder))
    throw Error(ErrorCode::kUnwritableOutput, folder.string() + ": the folder cannot be made: " + error.message());
}

} // namespace

PngWriter::Layout PngWriter::layout_of(const std::string& option, const fs::path& path) {
  if (option == "folder") return Layout::kFolder;
  if (option == "file") return Layout::kFile;
  return without_part(path).extension() == ".png" ? Layout::kFile : Layout::kFolder;
}

PngWriter::PngWriter(fs::path path, Layout layout) : path_(std::move(path)), layout_(layout) {
  if (layout_ == Layout::kFolder)
    make_folder(path_);
  else
    write_file(path_, {});
}

void PngWriter::write(const KinoraPicture& picture) {
  if (layout_ == Layout::kFile && written_ > 0)
    throw Error(ErrorCode::kUsage, path_.string() + ": a single PNG holds one picture; write to a folder instead");
  fs::path path = path_;
  if (layout_ == Layout::kFolder) {
    const fs::path name = fs::path(picture.name).lexically_normal();
    if (name.empty() || name.is_absolute() || *name.begin() == "..")
      throw Error(ErrorCode::kUsage, std::string("the picture's name \"") + picture.name +
                                         "\" leaves the output folder; give a name inside it");
    path = path_ / name;
    path += ".png";
    if (path.parent_path() != path_) make_folder(path.parent_path());
  }
  write_file(path, encode_png(color_of(picture.color)));
  if (picture.depth.data != nullptr) write_file(path_beside(path, ".depth.png"), encode_png16(depth_of(picture.depth)));
  if (picture.normal.data != nullptr)
    write_file(path_beside(path, ".normal.png"), encode_png(as_colors(normal_of(picture.normal))));
  if (picture.confidence.data != nullptr)
    write_file(path_beside(path, ".confidence.png"), encode_png(confidence_of(picture.confidence)));
  ++written_;
}

void PngWriter::finish() const {
  if (layout_ == Layout::kFile && written_ == 0)
    throw Error(ErrorCode::kFailure, path_.string() + ": no picture was written");
}

} // namespace kinora::formats
