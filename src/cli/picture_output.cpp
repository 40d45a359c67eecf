#include "cli/picture_output.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <system_error>

#include <fmt/format.h>

#include "cli/output_file.h"
#include "cli/staged_files.h"
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

/// Depth in metres has no place in the files beside a PNG: such formats hold all of a picture in one file.
bool holds_passes(const KinoraFormat& format) { return host::supports(format, KINORA_WRITES_METRIC_DEPTH); }

/// How the names of files end that stand beside the picture's own, which holds the other passes.
std::vector<std::string> ends_beside(const KinoraFormat& format, const PictureRequest& request) {
  std::vector<std::string> ends;
  for (const std::string& pass : request.passes) {
    if (pass == "deep") ends.emplace_back(".deep.exr");
    if (pass != "deep" && !holds_passes(format)) ends.push_back("." + pass + ".png");
  }
  return ends;
}

DepthImage16 millimetres_of(const DepthImage& metres) {
  DepthImage16 depth(metres.width(), metres.height());
  for (std::size_t i = 0; i < metres.pixel_count(); ++i) {
    const double millimetres = std::round(1000.0 * metres.data()[i]);
    depth.data()[i] = static_cast<std::uint16_t>(std::clamp(millimetres, 0.0, 65535.0));
  }
  return depth;
}

/// The labels of what is in front; `labels`: of the layers that were drawn.
LabelImage labels_of(const LabelImage& front, const std::vector<host::LabelMeaning>& labels) {
  if (front.empty()) return {};
  LabelImage image(front.width(), front.height());
  for (std::size_t i = 0; i < front.pixel_count(); ++i) {
    const std::size_t layer = front.data()[i];
    if (layer > 0 && layer <= labels.size()) image.data()[i] = static_cast<std::uint8_t>(labels[layer - 1].label);
  }
  return image;
}

/// Depth in millimetres only where it is asked for; the rest is given to those formats alone that hold it.
host::Picture picture_for(const KinoraFormat& format, const DrawnPicture& drawn, const PictureRequest& request) {
  host::Picture picture{drawn.name, drawn.seconds,        drawn.picture.color,
                        {},         drawn.picture.normal, drawn.picture.confidence};
  if (contains(request.passes, "depth")) picture.depth = millimetres_of(drawn.picture.depth);
  if (host::supports(format, KINORA_WRITES_METRIC_DEPTH)) picture.metric_depth = drawn.picture.depth;
  if (host::supports(format, KINORA_WRITES_LABELS)) {
    picture.labels = labels_of(drawn.picture.front, drawn.labels);
    picture.label_meanings = drawn.labels;
  }
  picture.camera = drawn.camera;
  for (const DrawnLayer& layer : drawn.layers) {
    host::Picture one{layer.label.name, drawn.seconds, layer.picture.color, {}};
    one.metric_depth = layer.picture.depth;
    one.label_meanings = std::span(&layer.label, 1);
    picture.layers.push_back(std::move(one));
  }
  return picture;
}

/// Throws Error(kUsage) for a pass that the format has no place for.
const KinoraFormat& checked(const KinoraFormat& format, const Passes& passes) {
  constexpr std::array<std::pair<std::string_view, std::uint64_t>, 4> kPlaces{
      {{"depth", KINORA_WRITES_DEPTH | KINORA_WRITES_METRIC_DEPTH},
       {"normal", KINORA_WRITES_NORMALS},
       {"confidence", KINORA_WRITES_CONFIDENCE},
       {"deep", KINORA_WRITES_PICTURE_LAYERS}}};
  for (const auto& [pass, place] : kPlaces) {
    if (!contains(passes, pass) || (format.capabilities & place) != 0) continue;
    throw Error(
        ErrorCode::kUsage,
        fmt::format("the format {} has no place for the pass {}; leave it out of --passes, or choose png or exr",
                    format.name, pass));
  }
  return format;
}

/// A writer that makes files in a folder beside the output, from where each is moved to its place when it is whole.
class StagedWriter {
public:
  StagedWriter(const KinoraFormat& format, const fs::path& output, const host::Options& options,
               const host::Facts& facts)
      : files_(output), writer_(format, files_.folder(), options, facts) {}

  const KinoraFormat& format() const { return writer_.format(); }
  void write(const host::Picture& picture) { writer_.write(picture); }
  void finish() { writer_.finish(); }
  const StagedFiles& files() const { return files_; }

private:
  StagedFiles files_;
  host::PictureWriter writer_;
};

class FilmOutput : public PictureOutput {
public:
  FilmOutput(const PictureRequest& request, const host::PluginTable& plugins)
      : file_(request.path, request.overwrite, request.inputs),
        writer_(picture_format(request, plugins), file_.writing_path(), request.options, request.facts) {}
  void add(const DrawnPicture& drawn) override { writer_.write(picture_for(writer_.format(), drawn, {})); }
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
  SinglePictureOutput(const PictureRequest& request, const KinoraFormat& format)
      : request_(request), file_(request.path, request.overwrite, request.inputs),
        writer_(checked(format, request.passes), request.path, request.options, request.facts),
        beside_(ends_beside(format, request)) {
    for (const std::string& end : beside_) {
      const fs::path file = request.path.parent_path() / (request.path.stem().string() + end);
      files_beside_.push_back(std::make_unique<OutputFile>(file, request.overwrite, request.inputs));
    }
  }
  void add(const DrawnPicture& drawn) override {
    host::Picture picture = picture_for(writer_.format(), drawn, request_);
    picture.name = "picture";
    writer_.write(picture);
  }
  void finish() override {
    writer_.finish();
    writer_.files().move([this](const fs::path& inside) {
      for (std::size_t i = 0; i < beside_.size(); ++i) {
        if (inside.string().ends_with(beside_[i])) return files_beside_[i]->writing_path();
      }
      return file_.writing_path();
    });
    for (const auto& file : files_beside_) file->commit();
    file_.commit();
  }

private:
  PictureRequest request_;
  OutputFile file_;
  StagedWriter writer_;
  std::vector<std::string> beside_;                       // how their names end
  std::vector<std::unique_ptr<OutputFile>> files_beside_; // as beside_
};

/// Pictures that share a file, or that another file lists, are not known by their names.
void check_resume(const PictureRequest& request, const KinoraFormat& format, OutputKind kind) {
  const auto views = request.options.find("views");
  const bool share = views != request.options.end() && views->second != "files";
  if (!request.resume || (kind == OutputKind::kFolder && !share && *format.extensions != '\0')) return;
  throw Error(ErrorCode::kUsage, "--resume is for folders with a file for each picture");
}

class FolderOutput : public PictureOutput {
public:
  FolderOutput(const PictureRequest& request, const std::vector<std::string>& names, const KinoraFormat& format,
               const host::Options& options)
      : request_(request), writer_(format, free_folder(request, names, format) / "", options, request.facts) {}
  bool is_done(const std::string& name) const override {
    std::error_code ignored;
    return request_.resume &&
           std::ranges::all_of(files_of(request_, name, writer_.format()), [&](const fs::path& file) {
             return fs::exists(file, ignored) && !written_.contains(file.lexically_normal());
           });
  }
  void add(const DrawnPicture& drawn) override {
    writer_.write(picture_for(writer_.format(), drawn, request_));
    move();
  }
  void finish() override {
    writer_.finish();
    move();
  }

private:
  void move() {
    writer_.files().move([this](const fs::path& inside) {
      fs::path target = request_.path / inside;
      if (!written_.insert(target.lexically_normal()).second) unwritable(target, "two pictures have this name");
      refuse_to_lose(target, request_);
      return target;
    });
  }

  /// What can be known before anything is drawn; move() holds whatever the writer makes of the names.
  static const fs::path& free_folder(const PictureRequest& request, const std::vector<std::string>& names,
                                     const KinoraFormat& format) {
    checked(format, request.passes);
    std::error_code error;
    if (fs::exists(request.path, error) && !fs::is_directory(request.path, error)) {
      unwritable(request.path, "it is not a folder; name a folder, a .png or a .mp4");
    }
    for (const std::string& name : names)
      for (const fs::path& file : files_of(request, name, format)) refuse_to_lose(file, request);
    return request.path;
  }

  /// A picture with its passes.
  static std::vector<fs::path> files_of(const PictureRequest& request, const std::string& name,
                                        const KinoraFormat& format) {
    const std::string extensions = format.extensions;
    std::vector<std::string> ends = ends_beside(format, request);
    ends.push_back(extensions.substr(0, extensions.find(' ')));
    std::vector<fs::path> files;
    files.reserve(ends.size());
    for (const std::string& end : ends) files.push_back(request.path / (name + end));
    return files;
  }

  static void refuse_to_lose(const fs::path& file, const PictureRequest& request) {
    std::error_code error;
    for (const fs::path& input : request.inputs) {
      if (fs::equivalent(file, input, error)) unwritable(file, "it is also the input; give another folder");
    }
    if (request.overwrite || request.resume || !fs::exists(fs::symlink_status(file, error))) return;
    unwritable(file, "it exists already; add --overwrite to replace it, or give another folder");
  }

  PictureRequest request_;
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

const KinoraFormat& picture_format(const PictureRequest& request, const host::PluginTable& plugins) {
  if (output_kind(request.path, plugins) != OutputKind::kFolder) return plugins.writer_for(request.path);
  const auto chosen = request.options.find("format");
  return plugins.find(chosen == request.options.end() ? std::string(kDefaultFormat) : chosen->second);
}

std::unique_ptr<PictureOutput> PictureOutput::open(const PictureRequest& request, const std::vector<std::string>& names,
                                                   const host::PluginTable& plugins) {
  const OutputKind kind = output_kind(request.path, plugins);
  check_resume(request, picture_format(request, plugins), kind);
  switch (kind) {
  case OutputKind::kFilm:
    return std::make_unique<FilmOutput>(request, plugins);
  case OutputKind::kPicture:
    return std::make_unique<SinglePictureOutput>(request, picture_format(request, plugins));
  case OutputKind::kFolder:
    break;
  }
  host::Options options = request.options;
  options.erase("format");
  const KinoraFormat& format = picture_format(request, plugins);
  host::check_options(format, options); // before there is a folder
  return std::make_unique<FolderOutput>(request, names, format, options);
}

} // namespace kinora::cli
