#include "png/png_writer.h"

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
fs::path depth_path_of(const fs::path& color_path) {
  fs::path path = without_part(color_path);
  path.replace_extension(".depth.png");
  if (path != color_path && color_path.extension() == kPartSuffix) path += kPartSuffix;
  return path;
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
  if (picture.depth.data != nullptr) write_file(depth_path_of(path), encode_png16(depth_of(picture.depth)));
  ++written_;
}

void PngWriter::finish() const {
  if (layout_ == Layout::kFile && written_ == 0)
    throw Error(ErrorCode::kFailure, path_.string() + ": no picture was written");
}

} // namespace kinora::formats
