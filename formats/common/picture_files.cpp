#include "common/picture_files.h"

#include "common/files.h"
#include "core/error.h"

namespace kinora::formats {
namespace fs = std::filesystem;

namespace {

constexpr const char* kPartSuffix = ".part";

} // namespace

fs::path without_part(const fs::path& path) {
  return path.extension() == kPartSuffix ? fs::path(path).replace_extension() : path;
}

fs::path path_beside(const fs::path& path, const std::string& extension) {
  fs::path beside = without_part(path);
  beside.replace_extension(extension);
  if (path.extension() == kPartSuffix) beside += kPartSuffix;
  return beside;
}

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error || !fs::is_directory(folder))
    throw Error(ErrorCode::kUnwritableOutput, folder.string() + ": the folder cannot be made: " + error.message());
}

fs::path path_inside(const fs::path& folder, const std::string& name) {
  const fs::path inside = fs::path(name).lexically_normal();
  if (inside.empty() || inside.is_absolute() || *inside.begin() == "..")
    throw Error(ErrorCode::kUsage,
                "the picture's name \"" + name + "\" leaves the output folder; give a name inside it");
  return folder / inside;
}

PictureFiles::Layout PictureFiles::layout_of(const std::string& option, const fs::path& path,
                                             const std::string& extension) {
  if (option == "folder") return Layout::kFolder;
  if (option == "file") return Layout::kFile;
  return without_part(path).extension() == extension ? Layout::kFile : Layout::kFolder;
}

PictureFiles::PictureFiles(fs::path path, Layout layout, std::string extension)
    : path_(std::move(path)), layout_(layout), extension_(std::move(extension)) {
  if (layout_ == Layout::kFolder)
    make_folder(path_);
  else
    write_file(path_, {});
}

fs::path PictureFiles::next(const std::string& name) {
  if (layout_ == Layout::kFile) {
    if (count_++ > 0)
      throw Error(ErrorCode::kUsage, path_.string() + ": a single file holds one picture; write to a folder instead");
    return path_;
  }
  fs::path path = path_inside(path_, name);
  path += extension_;
  if (path.parent_path() != path_) make_folder(path.parent_path());
  ++count_;
  return path;
}

void PictureFiles::finish() const {
  if (layout_ == Layout::kFile && count_ == 0)
    throw Error(ErrorCode::kFailure, path_.string() + ": no picture was written");
}

} // namespace kinora::formats
