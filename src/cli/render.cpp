// kinora render: a clip drawn from any camera, at any of its times.
#include <algorithm>
#include <array>
#include <charconv>
#include <fstream>
#include <map>
#include <memory>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/clip_input.h"
#include "cli/commands.h"
#include "cli/drawn_pictures.h"
#include "cli/export_facts.h"
#include "cli/picture_output.h"
#include "cli/versions.h"
#include "container/crc32c.h"
#include "core/error.h"
#include "player/as_recorded.h"
#include "player/camera_file.h"

namespace kinora::cli {
namespace {

/// How bright a picture is: all alike, or as each frame of the capture was recorded.
enum class ExposureChoice { kEven, kCapture };

/// Whether a picture shows one moment, or each row that at which the capture's camera read it.
enum class ShutterChoice { kGlobal, kCapture };

struct Options {
  std::filesystem::path clip;
  std::filesystem::path out;
  std::filesystem::path cameras;
  double orbit = 0;
  bool has_orbit = false;
  bool capture_view = false;
  std::string frames;
  std::string size;
  fields::DrawQuality quality = fields::DrawQuality::kFull;
  fields::Unseen unseen = fields::Unseen::kKeep;
  ExposureChoice exposure = ExposureChoice::kEven;
  ShutterChoice shutter = ShutterChoice::kGlobal;
  std::vector<std::string> layers;
  std::vector<std::string> passes{"rgb"};
  std::vector<std::string> writer_options;
  bool resume = false;
};

std::pair<int, int> parse_size(const std::string& text) {
  const std::size_t cross = text.find('x');
  int width = 0;
  int height = 0;
  const auto number = [](std::string_view part, int& value) {
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
    return error == std::errc{} && end == part.data() + part.size();
  };
  const bool understood = cross != std::string::npos && number(std::string_view(text).substr(0, cross), width) &&
                          number(std::string_view(text).substr(cross + 1), height);
  if (!understood || width < 1 || height < 1 || width > 16384 || height > 16384) {
    throw Error(ErrorCode::kUsage,
                fmt::format("--size {} is no size; give WIDTHxHEIGHT in pixels, such as 640x480", text));
  }
  return {width, height};
}

/// The passes to write beside colour, each once.
std::vector<std::string> passes_beside_color(const std::vector<std::string>& passes) {
  constexpr std::array<std::string_view, 4> kBeside{"depth", "normal", "confidence", "deep"};
  std::vector<std::string> beside;
  bool rgb = false;
  for (const std::string& pass : passes) {
    if (pass == "rgb") {
      rgb = true;
    } else if (std::find(kBeside.begin(), kBeside.end(), pass) == kBeside.end()) {
      throw Error(ErrorCode::kUsage,
                  fmt::format("there is no pass \"{}\"; there are rgb, {}", pass, fmt::join(kBeside, ", ")));
    } else if (std::find(beside.begin(), beside.end(), pass) == beside.end()) {
      beside.push_back(pass);
    }
  }
  if (!rgb) throw Error(ErrorCode::kUsage, "--passes needs rgb, which the other passes stand beside: rgb,depth");
  return beside;
}

std::vector<player::View> views_of(const Options& options, const player::Player& player, Context& context) {
  if (options.cameras.empty()) {
    const std::vector<int> frames = frames_in_range(options.frames, player.frame_count());
    return options.has_orbit ? player::orbit_views(player, frames, options.orbit)
                             : player::capture_views(player.clip(), frames);
  }
  const auto all = player::read_camera_file(options.cameras, player.clip(), context.progress);
  std::vector<player::View> chosen;
  for (const int i : frames_in_range(options.frames, all.size())) chosen.push_back(all[static_cast<std::size_t>(i)]);
  return chosen;
}

// Seconds from the first view. A film shows each view when the clip does; where that is not one after another, at the
// clip's pace.
std::vector<double> show_times(const std::vector<player::View>& views, const clip::Clip& clip, OutputKind kind) {
  std::vector<double> times;
  for (const player::View& view : views) {
    const auto before = static_cast<std::size_t>(view.frame);
    const std::size_t after = std::min(before + 1, clip.times.size() - 1);
    const double fraction = view.frame - static_cast<double>(before);
    times.push_back(clip.times[before] + fraction * (clip.times[after] - clip.times[before]));
  }
  const bool increasing = kind != OutputKind::kFilm ||
                          std::adjacent_find(times.begin(), times.end(), std::greater_equal<>()) == times.end();
  const double start = times.front();
  for (std::size_t i = 0; i < times.size(); ++i) {
    times[i] = increasing ? times[i] - start : static_cast<double>(i) / frames_per_second(clip);
  }
  return times;
}

// Clips of earlier versions do not hold it.
void require_confidence(const clip::Clip& clip, const player::LayerChoice& layers, const std::filesystem::path& file) {
  for (const std::size_t i : layers) {
    if (clip.layers[i].confidence) continue;
    throw Error(ErrorCode::kFailure,
                fmt::format("{} does not say how well layer {} was seen: an earlier Kinora made "
                            "it; encode its capture again, or draw without the pass confidence and without "
                            "--unseen fade",
                            file.string(), clip.layers[i].name));
  }
}

/// Of the layers that a picture of a frame shows.
std::vector<host::LabelMeaning> labels_at(const player::Player& player, const player::LayerChoice& layers,
                                          double frame) {
  std::vector<host::LabelMeaning> labels;
  for (const std::size_t i : player.drawn_layers(frame, layers)) {
    const clip::Layer& layer = player.clip().layers[i];
    labels.push_back({layer.label, layer.name, std::string(motion::name_of(layer.motion.kind()))});
  }
  return labels;
}

/// Each of the layers that are there then by itself.
std::vector<DrawnLayer> draw_layers(const player::Player& player, const player::View& view,
                                    const player::LayerChoice& layers, const fields::DrawOptions& how) {
  std::vector<DrawnLayer> drawn;
  for (const std::size_t i : layers) {
    const std::vector<host::LabelMeaning> label = labels_at(player, {i}, view.frame);
    if (!label.empty()) drawn.push_back({player.draw(view.camera, view.frame, {i}, how), label.front()});
  }
  return drawn;
}

std::uint32_t checksum_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::array<char, 1 << 16> piece{};
  std::uint32_t checksum = 0;
  while (stream.read(piece.data(), piece.size()) || stream.gcount() > 0)
    checksum =
        container::crc32c(std::as_bytes(std::span(piece).first(static_cast<std::size_t>(stream.gcount()))), checksum);
  return checksum;
}

/// Pictures of a film out of what an earlier run has left, or drawn and left for a later one (--resume).
class ResumableDrawing {
public:
  ResumableDrawing(const Options& options, const player::LayerChoice& layers)
      : kept_(options.out.string() + ".drawn"),
        how_(fmt::format("{}\n{:08x} {} {} {} {} {}", version_text(), checksum_of(options.clip),
                         static_cast<int>(options.quality), static_cast<int>(options.unseen),
                         static_cast<int>(options.exposure), static_cast<int>(options.shutter),
                         fmt::join(layers, ","))) {}

  template <class Draw> fields::Picture picture(std::size_t index, const player::View& view, const Draw& draw) {
    const Intrinsics& k = view.camera.intrinsics;
    const std::string from = fmt::format("{} {} {} {} {} {} {} {} {}", how_, view.frame, k.width, k.height, k.fx, k.fy,
                                         k.cx, k.cy, fmt::join(view.camera.camera_to_world.matrix().reshaped(), " "));
    const std::uint32_t key = container::crc32c(std::as_bytes(std::span(from)));
    if (std::optional<ColorImage> found = kept_.find(index, key)) return {*std::move(found), {}, {}};
    fields::Picture drawn = draw();
    kept_.keep(index, key, drawn.color);
    return drawn;
  }
  void finish() { kept_.remove(); }

private:
  DrawnPictures kept_;
  std::string how_;
};

void require_capture_view(const Options& options) {
  if (options.cameras.empty() && !options.has_orbit) return;
  const auto refuse = [](const char* what) {
    throw Error(ErrorCode::kUsage, fmt::format("{}; it goes with --capture-view, not with --cameras or --orbit", what));
  };
  if (options.exposure == ExposureChoice::kCapture)
    refuse("--exposure capture is how bright the capture's own frames are");
  if (options.shutter == ShutterChoice::kCapture)
    refuse("--shutter capture is how the capture's own camera read its pictures");
}

std::string cameras_text(const Options& options) {
  if (!options.cameras.empty()) return options.cameras.filename().string();
  return options.has_orbit ? fmt::format("orbit of {:g} degrees", options.orbit) : "the capture's";
}

void run(const Options& options, Context& context) {
  require_capture_view(options);
  const std::vector<std::string> beside = passes_beside_color(options.passes);
  PictureRequest request{options.out,
                         host::parse_options(options.writer_options),
                         context.shared.overwrite,
                         beside,
                         {options.clip, options.cameras}};
  const OutputKind kind = output_kind(options.out, context.plugins());
  if (!beside.empty() && kind == OutputKind::kFilm) {
    throw Error(ErrorCode::kUsage, fmt::format("a film has no place for {}; render --passes rgb,{} into a folder",
                                               fmt::join(beside, " and "), fmt::join(beside, ",")));
  }
  const player::Player player(open_clip(options.clip, context.progress));
  const player::LayerChoice layers = options.layers.empty()
                                         ? player.all_layers()
                                         : clip::choose_layers(player.clip(), options.layers, context.progress);
  const auto has = [&beside](std::string_view pass) {
    return std::find(beside.begin(), beside.end(), pass) != beside.end();
  };
  if (has("confidence") || options.unseen == fields::Unseen::kFade) {
    require_confidence(player.clip(), layers, options.clip);
  }
  std::vector<player::View> views = views_of(options, player, context);
  if (kind == OutputKind::kPicture) views.resize(1);
  if (!options.size.empty()) {
    const auto [width, height] = parse_size(options.size);
    for (player::View& view : views) view.camera.intrinsics = view.camera.intrinsics.resized(width, height);
  }
  // Views of one time belong together.
  if (kind == OutputKind::kFolder) std::ranges::stable_sort(views, {}, &player::View::frame);
  std::vector<std::string> names;
  names.reserve(views.size());
  for (const player::View& view : views) names.push_back(view.name);
  const std::vector<double> times = show_times(views, player.clip(), kind);

  const PictureExport pictures{
      player.clip(), picture_format(request, context.plugins()), options.clip, cameras_text(options), views, layers,
      beside};
  request.facts = facts_of(pictures);
  request.resume = options.resume && kind != OutputKind::kFilm;
  const player::AsRecorded recorded(
      player.clip(), {options.exposure == ExposureChoice::kCapture, options.shutter == ShutterChoice::kCapture});
  const fields::DrawOptions draw{options.quality, has("normal"), has("confidence"), options.unseen};
  const auto output = PictureOutput::open(request, names, context.plugins());
  std::optional<ResumableDrawing> resumable;
  if (options.resume && kind == OutputKind::kFilm) resumable.emplace(options, layers);
  context.progress.stage("drawing", views.size());
  for (std::size_t i = 0; i < views.size(); ++i) {
    context.progress.check();
    const player::View& view = views[i];
    if (output->is_done(view.name)) continue;
    const auto as_recorded = [&](fields::Picture picture) {
      recorded.apply_to(picture, view.camera.intrinsics, static_cast<std::size_t>(std::lround(view.frame)));
      return picture;
    };
    const auto drawn = [&] { return as_recorded(player.draw(view.camera, view.frame, layers, draw)); };
    std::vector<DrawnLayer> deep;
    if (has("deep")) deep = draw_layers(player, view, layers, {options.quality, false, false, options.unseen});
    for (DrawnLayer& layer : deep) layer.picture = as_recorded(std::move(layer.picture));
    output->add({resumable ? resumable->picture(i, view, drawn) : drawn(), view.name, times[i], view.camera,
                 labels_at(player, layers, view.frame), std::move(deep)});
    context.progress.advance(i + 1, "");
  }
  output->finish();
  if (resumable) resumable->finish();
  if (context.shared.json) {
    context.print_json({{"schema", "kinora.render/1"},
                        {"output", options.out.string()},
                        {"pictures", views.size()},
                        {"lost", losses_of(pictures)},
                        {"size", {views[0].camera.intrinsics.width, views[0].camera.intrinsics.height}}});
  } else {
    context.print(fmt::format("{}: {} picture{} of {}x{} pixels\n{}", options.out.string(), views.size(),
                              views.size() == 1 ? "" : "s", views[0].camera.intrinsics.width,
                              views[0].camera.intrinsics.height, losses_text(losses_of(pictures))));
  }
}

void add_view_options(CLI::App& command, Options& options) {
  auto* cameras = command.add_option("--cameras", options.cameras,
                                     "Draw from the cameras of this transforms.json (instant-ngp, nerfstudio)");
  auto* orbit = command.add_option_function<double>(
      "--orbit",
      [&options](double degrees) {
        options.orbit = degrees;
        options.has_orbit = true;
      },
      "Stand this far to the right of the capture camera, around what the scene is about; a film swings to both sides");
  auto* capture_view = command.add_flag("--capture-view", options.capture_view,
                                        "Draw from where the capture camera stood (the default)");
  cameras->type_name("FILE")->excludes(orbit)->excludes(capture_view);
  orbit->type_name("DEGREES")->excludes(capture_view)->check(CLI::Range(-360.0, 360.0));
}

} // namespace

void add_render(CLI::App& app, Context& context) {
  const auto options = std::make_shared<Options>();
  CLI::App& command = context.add_command(app, "render", "Draw a clip from any camera, as pictures or a film",
                                          "  kinora render clip.mkv side.png --orbit 30 --frames 45\n"
                                          "  kinora render clip.mkv film.mp4 --orbit 20 --size 960x720\n"
                                          "  kinora render clip.mkv dataset/ -O format=data-set\n"
                                          "  kinora render clip.mkv pictures/ --cameras transforms.json "
                                          "--layers object --passes rgb,depth,normal",
                                          [options, &context] { run(*options, context); });
  command.add_option("CLIP", options->clip, "The clip to draw")->required()->type_name("FILE");
  command
      .add_option("OUT", options->out,
                  "A .mp4 or .webm film, a .png or .exr of the first view, or a folder for one .png per view; -O "
                  "format=exr: one "
                  ".exr; -O format=data-set: a data set for other programs to train on")
      ->required()
      ->type_name("PATH");
  add_view_options(command, *options);
  command
      .add_option("--frames", options->frames, "Only these frames (or cameras of the file); counts from 0, B excluded")
      ->type_name("A:B:S");
  command.add_option("--size", options->size, "Size of the pictures; the field of view stays")->type_name("WxH");
  command
      .add_option("--quality", options->quality,
                  "full, or fast: drawn at half the size and enlarged, in less than half the time")
      ->transform(
          CLI::CheckedTransformer(std::map<std::string, fields::DrawQuality>{{"full", fields::DrawQuality::kFull},
                                                                             {"fast", fields::DrawQuality::kFast}},
                                  CLI::ignore_case))
      ->type_name("full|fast");
  command
      .add_option("--unseen", options->unseen,
                  "What to do with surfaces that no camera ever saw from the side that is shown: keep, drawn with the "
                  "colours nearest to them; or fade, left out")
      ->transform(CLI::CheckedTransformer(
          std::map<std::string, fields::Unseen>{{"keep", fields::Unseen::kKeep}, {"fade", fields::Unseen::kFade}},
          CLI::ignore_case))
      ->type_name("keep|fade");
  command
      .add_option("--exposure", options->exposure,
                  "even: all pictures as bright as the clip; capture: each as bright, and as white, as the capture's "
                  "frame was recorded")
      ->transform(CLI::CheckedTransformer(
          std::map<std::string, ExposureChoice>{{"even", ExposureChoice::kEven}, {"capture", ExposureChoice::kCapture}},
          CLI::ignore_case))
      ->type_name("even|capture");
  command
      .add_option("--shutter", options->shutter,
                  "global: a picture is of one moment; capture: row by row, as the capture's camera read it while it "
                  "moved")
      ->transform(CLI::CheckedTransformer(std::map<std::string, ShutterChoice>{{"global", ShutterChoice::kGlobal},
                                                                               {"capture", ShutterChoice::kCapture}},
                                          CLI::ignore_case))
      ->type_name("global|capture");
  command.add_option("--layers", options->layers, "Only these layers, such as person,object")
      ->delimiter(',')
      ->type_name("NAMES");
  command
      .add_option(
          "--passes", options->passes,
          "What to write: rgb, and beside it .depth.png (16-bit millimetres), .normal.png (of the camera: "
          "x right, y up, z back, as colours), .confidence.png (8 bits: 255 where the capture's cameras saw well "
          "what is shown, 0 where they never saw that side), with -O format=exr also deep: .deep.exr, each layer a "
          "sample of its pixels")
      ->delimiter(',')
      ->type_name("NAMES");
  command.add_option("-O", options->writer_options, "An option of the format that writes (see kinora formats)")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  command.add_flag("--resume", options->resume,
                   "Keep pictures of a folder that are there, and draw the rest as the same command would have; of a "
                   "film, keep what is drawn in OUT.drawn/ until it is whole, and use what an earlier run left there");
  context.add_overwrite(command);
}

} // namespace kinora::cli
