// kinora convert: a clip becomes what other tools open, and a capture another format of captures.
#include <algorithm>
#include <memory>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/capture_conversion.h"
#include "cli/clip_input.h"
#include "cli/commands.h"
#include "cli/conversion.h"
#include "cli/export_facts.h"
#include "cli/export_options.h"
#include "cli/text.h"
#include "core/error.h"

namespace kinora::cli {
namespace {

using Json = nlohmann::json;

constexpr std::uint64_t kWritable = KINORA_WRITES_MESHES | KINORA_WRITES_VOLUMES | KINORA_WRITES_FRAMES;
constexpr const char* kFolderFormat = "tum-rgbd"; ///< of an OUTPUT without extension: it keeps the most

struct Options {
  std::filesystem::path input;
  std::filesystem::path output;
  std::string from;
  std::string to;
  std::string frames;
  bool dry_run = false;
  bool resume = false;
  bool strict = false;
  std::vector<std::string> options;
};

void check_source(const Options& options, const host::PluginTable& plugins) {
  if (options.from.empty() || options.from == "clip") return;
  throw Error(ErrorCode::kUsage,
              fmt::format("--from {} reads captures, of which no meshes and volumes are made; make a clip first, with "
                          "kinora encode --format {}",
                          plugins.find(options.from).name, options.from));
}

const KinoraFormat& target_of(const Options& options, const host::PluginTable& plugins) {
  if (options.to.empty() && !options.output.has_extension()) return plugins.find(kFolderFormat);
  if (options.to.empty()) return plugins.writer_for(options.output, kWritable);
  const KinoraFormat& format = plugins.find(options.to);
  if ((format.capabilities & kWritable) != 0) return format;
  throw Error(
      ErrorCode::kUsage,
      fmt::format("the format {} writes neither meshes, volumes nor captures; for pictures and films use kinora render",
                  format.name));
}

Conversion conversion_of(const Options& options, const clip::Clip& clip, const KinoraFormat& format, Context& context) {
  Conversion conversion;
  conversion.clip = &clip;
  conversion.format = &format;
  conversion.input = options.input;
  conversion.output = options.output;
  conversion.frames = frames_in_range(options.frames, clip.times.size());
  conversion.strict = options.strict;
  conversion.resume = options.resume;
  if (options.resume && is_one_file(format))
    throw Error(ErrorCode::kUsage, fmt::format("--resume is for numbered files; the format {} has one", format.name));
  apply_options(host::parse_options(options.options), conversion, context);
  return conversion;
}

Json plan_json(const Conversion& conversion) {
  Json layers = Json::array();
  for (const std::size_t i : conversion.layers) {
    const clip::Layer& layer = conversion.clip->layers[i];
    layers.push_back({{"name", layer.name}, {"motion", motion::name_of(layer.motion.kind())}});
  }
  return {{"layers", std::move(layers)},
          {"files", is_one_file(*conversion.format) ? 1 : conversion.frames.size()},
          {"bytes", nullptr}};
}

std::string files_of(const Conversion& conversion) {
  if (is_one_file(*conversion.format)) return conversion.output.string();
  std::string first = numbered_path(conversion.output, 0).string();
  if (conversion.frames.size() == 1) return first;
  return fmt::format("{} to {}", first, numbered_path(conversion.output, conversion.frames.size() - 1).string());
}

std::string summary(const Conversion& conversion, const Json& result, bool dry_run) {
  const std::size_t frames = conversion.frames.size();
  std::string text = fmt::format("{}: {}{} frame{}", files_of(conversion), dry_run ? "would hold " : "", frames,
                                 frames == 1 ? "" : "s");
  if (!dry_run) text += ", " + format_bytes(result["bytes"].get<std::size_t>());
  text += "\n";
  const bool has_meshes = std::ranges::any_of(result["layers"], [](const Json& l) { return l.contains("triangles"); });
  Table table(has_meshes ? std::vector<std::string>{"layer", "motion", "triangles", "joints"}
                         : std::vector<std::string>{"layer", "motion"});
  for (const Json& layer : result["layers"]) {
    std::vector<std::string> row{layer["name"], layer["motion"]};
    if (has_meshes) {
      row.push_back(layer.contains("triangles") ? layer["triangles"].dump() : "");
      row.push_back(layer.contains("joints") ? layer["joints"].dump() : "");
    }
    table.add(row);
  }
  return text + table.str() + losses_text(losses_of(conversion));
}

void run_capture(const Options& options, const KinoraFormat& target, Context& context) {
  CaptureConversion conversion;
  conversion.input = options.input;
  conversion.output = options.output;
  conversion.source_format = options.from;
  conversion.target = &target;
  if (!options.frames.empty()) conversion.frames = FrameRange::parse(options.frames);
  conversion.options = host::parse_options(options.options);
  conversion.dry_run = options.dry_run;
  conversion.strict = options.strict;
  convert_capture(conversion, context);
}

void run(const Options& options, Context& context) {
  const KinoraFormat& format = target_of(options, context.plugins());
  if (host::supports(format, KINORA_WRITES_FRAMES)) return run_capture(options, format, context);
  check_source(options, context.plugins());
  const clip::Clip clip = open_clip(options.input, context.progress);
  const Conversion conversion = conversion_of(options, clip, format, context);
  Json result = options.dry_run                                    ? plan_json(conversion)
                : is_one_file(format)                              ? convert_to_meshes(conversion, context)
                : host::supports(format, KINORA_WRITES_MESH_FRAME) ? convert_to_mesh_sequence(conversion, context)
                                                                   : convert_to_volumes(conversion, context);
  if (context.shared.json) {
    result["schema"] = "kinora.convert/1";
    result["output"] = options.output.string();
    result["format"] = format.name;
    result["frames"] = conversion.frames.size();
    result["dry_run"] = options.dry_run;
    result["lost"] = losses_of(conversion);
    context.print_json(result);
  } else {
    context.print(summary(conversion, result, options.dry_run));
  }
}

} // namespace

void report_loss(const Conversion& conversion, const std::string& sentence, Context& context) {
  if (conversion.strict) throw Error(ErrorCode::kFailure, sentence + "; without --strict this is a warning");
  context.progress.warn(sentence);
}

void add_convert(CLI::App& app, Context& context) {
  const auto options = std::make_shared<Options>();
  CLI::App& command =
      context.add_command(app, "convert", "Turn a clip into meshes or volumes, or a capture into another format",
                          "  kinora convert clip.mkv clip.glb\n"
                          "  kinora convert clip.mkv person.glb -O layers=person -O triangles=50000\n"
                          "  kinora convert clip.mkv points/clip.ply -O content=points\n"
                          "  kinora convert clip.mkv volumes/clip.vdb --frames 0:30 -O voxel=0.02\n"
                          "  kinora convert camera.bag recording.mkv\n"
                          "  kinora convert recording.mkv folder --to transforms",
                          [options, &context] { run(*options, context); });
  command.add_option("INPUT", options->input, "The clip, or the capture, to convert")->required()->type_name("PATH");
  command
      .add_option(
          "OUTPUT", options->output,
          "NAME.glb or .usda: all frames in one animated file; NAME.ply, .obj or .vdb: NAME_0001.ply and so on, "
          "one per frame; of a capture, NAME.mkv: a recording, else a folder")
      ->required()
      ->type_name("PATH");
  command.add_option("--from", options->from, "What the input is: clip, or a format of captures")->type_name("FORMAT");
  command.add_option("--to", options->to, "Write this format (see kinora formats); else as OUTPUT's name says")
      ->type_name("FORMAT");
  command.add_option("--frames", options->frames, "Only these frames; counts from 0, B is excluded")
      ->type_name("A:B:S");
  command.add_flag("--dry-run", options->dry_run, "Say what would be written, and write nothing");
  command.add_flag("--resume", options->resume,
                   "Keep numbered files that are there, and write the rest as the same command would have");
  command.add_flag("--strict", options->strict,
                   "Fail where the output cannot carry what the input has, or a frame is damaged; do not just warn");
  command
      .add_option("-O", options->options,
                  "layers=NAMES; fps=N; origin=X,Y,Z; of meshes triangles=N per layer; of volumes voxel=METRES; or "
                  "another option of the format (see kinora formats)")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  context.add_overwrite(command);
}

} // namespace kinora::cli
