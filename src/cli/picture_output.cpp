#include "cli/picture_output.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <set>
#include <system_error>

#include <fmt/format.h>

#include "cli/output_file.h"
#include "core/error.h"
#include "host/picture_writer.h"

namespace kinora::cli {
namespace fs = std::filesystem;
namespace {

constexpr std::string_view kDefaultFormat = "png";

using Passes = std::vector<std::string>;

[[noreturn]] void unwritable(const fs::path& path, const std::string& why) {
  throw Error(ErrorCode::kUnwritableOutput, fmt::format("{} cannot be written: {}", path.string(), why));
}

bool contains(const Passes& passes, std::string_view pass) {
  return std::find(passes.begin(), passes.end(), pass) != passes.end();
}

host::Picture picture_for(const fields::Picture& drawn, const std::string& name, double seconds, const Passes& beside) {
  host::Picture picture{name, seconds, drawn.color, {}, drawn.normal, drawn.confidence};
  if (!contains(beside, "depth")) return picture;
  picture.depth = DepthImage16(drawn.depth.width(), drawn.depth.height());
  for (std::size_t i = 0; i < drawn.depth.pixel_count(); ++i) {
    const double millimetres = std::round(1000.0 * drawn.depth.data()[i]);
    picture.depth.data()[i] = static_cast<std::uint16_t>(std::clamp(millimetres, 0.0, 65535.0));
  }
  return picture;
}

/// A writer that puts files into a folder beside the output, from where each is moved to its place when it is whole.
class StagedWriter {
public:
  StagedWriter(const KinoraFormat& format, const fs::path& output, const host::Options& options)
      : folder_(output, Unfinished::Kind::kFolder), writer_(format, folder_.path(), options) {}

  void write(const host::Picture& picture) { writer_.write(picture); }
  void finish() { writer_.finish(); }

  /// Moves every file to where `destination` says. Throws Error(kUnwritableOutput), and what `destination` throws.
  void move_files(const std::function<fs::path(const fs::path& inside)>& destination) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::recursive_directory_iterator(folder_.path())) {
      if (entry.is_regular_file()) files.push_back(entry.path());
    }
    for (const fs::path& file : files) {
      const fs::path target = destination(file.lexically_relative(folder_.path()));
      std::error_code error;
      if (target.has_parent_path()) fs::create_directories(target.parent_path(), error);
      fs::rename(file, target, error);
      if (error) unwritable(target, error.message());
    }
  }

private:
  Unfinished folder_;
  host::PictureWriter writer_;
};

class FilmOutput : public PictureOutput {
public:
  FilmOutput(const PictureRequest& request, const host::PluginTable& plugins)
      : file_(request.path, request.overwrite, request.inputs),
        writer_(plugins.writer_for(request.path), file_.writing_path(), request.options) {}
  void add(const fields::Picture& picture, const std::string& name, double seconds) override {
    writer_.write(picture_for(picture, name, seconds, {}));
  }
  void finish() override {
    writer_.finish();
    file_.commit();
  }

private:
  OutputFile file_;
  host::PictureWriter writer_;
};

/// One picture, and its other passes beside it.
class SinglePictureOutput : public PictureOutput {
public:
  SinglePictureOutput(const PictureRequest& request, const host::PluginTable& plugins)
      : path_(request.path), file_(request.path, request.overwrite, request.inputs),
        writer_(plugins.writer_for(request.path), request.path, request.options) {
    for (const std::string& pass : request.beside) {
      beside_.push_back(pass);
      const fs::path file = path_.parent_path() / (path_.stem().string() + "." + pass + ".png");
      files_beside_.push_back(std::make_unique<OutputFile>(file, request.overwrite, request.inputs));
    }
  }
  void add(const fields::Picture& picture, const std::string& /*name*/, double seconds) override {
    writer_.write(picture_for(picture, "picture", seconds, beside_));
  }
  void finish() override {
    writer_.finish();
    writer_.move_files([this](const fs::path& inside) {
      for (std::size_t i = 0; i < beside_.size(); ++i) {
        if (inside.stem().extension() == "." + beside_[i]) return files_beside_[i]->writing_path();
      }
      return file_.writing_path();
    });
    for (const auto& file : files_beside_) file->commit();
    file_.commit();
  }

private:
  fs::path path_;
  OutputFile file_;
  StagedWriter writer_;
  Passes beside_;
  std::vector<std::unique_ptr<OutputFile>> files_beside_; // as beside_
};

class FolderOutput : public PictureOutput {
public:
  FolderOutput(const PictureRequest& request, const std::vector<std::string>& names, const KinoraFormat& format,
               const host::Options& options)
      : path_(request.path), overwrite_(request.overwrite), beside_(request.beside), inputs_(request.inputs),
        writer_(format, checked(request, names, format) / "", options) {}
  void add(const fields::Picture& picture, const std::string& name, double seconds) override {
    writer_.write(picture_for(picture, name, seconds, beside_));
    move();
  }
  void finish() override {
    writer_.finish();
    move();
  }

private:
  void move() {
    writer_.move_files([this](const fs::path& inside) {
      fs::path target = path_ / inside;
      if (!written_.insert(target.lexically_normal()).second) unwritable(target, "two pictures have this name");
      refuse_to_lose(target, overwrite_, inputs_);
      return target;
    });
  }

  /// What can be known before anything is drawn; move() holds whatever the writer makes of the names.
  static const fs::path& checked(const PictureRequest& request, const std::vector<std::string>& names,
                                 const KinoraFormat& format) {
    std::error_code error;
    if (fs::exists(request.path, error) && !fs::is_directory(request.path, error)) {
      unwritable(request.path, "it is not a folder; name a folder, a .png or a .mp4");
    }
    const std::string extension = std::string(format.extensions).substr(0, std::string(format.extensions).find(' '));
    for (const std::string& name : names) {
      refuse_to_lose(request.path / (name + extension), request.overwrite, request.inputs);
      for (const std::string& pass : request.beside) {
        refuse_to_lose(request.path / fmt::format("{}.{}.png", name, pass), request.overwrite, request.inputs);
      }
    }
    return request.path;
  }

  static void refuse_to_lose(const fs::path& file, bool overwrite, const std::vector<fs::path>& inputs) {
    std::error_code error;
    for (const fs::path& input : inputs) {
      if (fs::equivalent(file, input, error)) unwritable(file, "it is also the input; give another folder");
    }
    if (overwrite || !fs::exists(fs::symlink_status(file, error))) return;
    unwritable(file, "it exists already; add --overwrite to replace it, or give another folder");
  }

  fs::path path_;
  bool overwrite_;
  Passes beside_;
  std::vector<fs::path> inputs_;
  std::set<fs::path> written_;
  StagedWriter writer_;
};

bool has_extension(const KinoraFormat& format, const std::string& extension) {
  return (" " + std::string(format.extensions) + " ").find(" " + extension + " ") != std::string::npos;
}

// Extensions that are surely no name of a folder.
constexpr std::array<std::string_view, 14> kPictureExtensions{
    ".png", ".jpg", ".jpeg", ".exr", ".tif", ".tiff", ".bmp", ".webp", ".mp4", ".mkv", ".mov", ".avi", ".webm", ".gif"};

} // namespace

OutputKind output_kind(const fs::path& path, const host::PluginTable& plugins) {
  std::error_code ignored;
  std::string extension = path.extension().string();
  if (extension.empty() || fs::is_directory(path, ignored)) return OutputKind::kFolder;
  for (const host::FormatEntry& entry : plugins.formats()) {
    if (!host::supports(*entry.format, KINORA_WRITES_PICTURES) || !has_extension(*entry.format, extension)) continue;
    return host::supports(*entry.format, KINORA_WRITES_FILM) ? OutputKind::kFilm : OutputKind::kPicture;
  }
  const bool surely_file =
      std::find(kPictureExtensions.begin(), kPictureExtensions.end(), extension) != kPictureExtensions.end();
  if (surely_file) plugins.writer_for(path); // throws, and lists what can be written
  return OutputKind::kFolder;
}

std::unique_ptr<PictureOutput> PictureOutput::open(const PictureRequest& request, const std::vector<std::string>& names,
                                                   const host::PluginTable& plugins) {
  switch (output_kind(request.path, plugins)) {
  case OutputKind::kFilm:
    return std::make_unique<FilmOutput>(request, plugins);
  case OutputKind::kPicture:
    return std::make_unique<SinglePictureOutput>(request, plugins);
  case OutputKind::kFolder:
    break;
  }
  host::Options options = request.options;
  const auto chosen = options.extract("format");
  const KinoraFormat& format = plugins.find(chosen ? chosen.mapped() : std::string(kDefaultFormat));
  return std::make_unique<FolderOutput>(request, names, format, options);
}

} // namespace kinora::cli
