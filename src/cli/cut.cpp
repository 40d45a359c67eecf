// kinora cut and kinora join: pieces of clips, without encoding again.
#include <memory>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "cli/clip_input.h"
#include "cli/commands.h"
#include "cli/companions.h"
#include "cli/output_file.h"
#include "cli/rate_choice.h"
#include "cli/text.h"
#include "clip/clip_edit.h"
#include "clip/clip_io.h"
#include "core/error.h"
#include "core/frame_range.h"

namespace kinora::cli {
namespace {

struct Options {
  std::filesystem::path input;
  std::filesystem::path second; ///< of join
  std::filesystem::path output;
  std::string frames;          ///< of cut
  double kb_per_frame = 0;     ///< of cut; 0: as it is
  CompanionOptions companions; ///< of cut
};

/// The clip is written; `said` is what is particular to the command.
void finish(const clip::StoredClip& clip, OutputFile& out, nlohmann::json said, Context& context) {
  if (!clip.others.empty()) {
    context.progress.warn(fmt::format("{}: left out, since a clip does not need it: {}", out.path().string(),
                                      fmt::join(clip.others, ", ")));
  }
  std::error_code ignored;
  const auto bytes = static_cast<std::size_t>(std::filesystem::file_size(out.writing_path(), ignored));
  out.commit();
  const clip::ClipDescription& about = clip.description;
  constexpr double kNanoseconds = 1e9;
  const double start = static_cast<double>(about.times_ns.front()) / kNanoseconds;
  const double end = static_cast<double>(about.times_ns.back()) / kNanoseconds;
  if (context.shared.json) {
    said.update({{"output", out.path().string()},
                 {"frames", about.times_ns.size()},
                 {"start_s", start},
                 {"end_s", end},
                 {"bytes", bytes},
                 {"left_out", clip.others}});
    context.print_json(said);
  } else {
    context.print(fmt::format("{}: {} frames, {:.2f} to {:.2f} s, {}\n", out.path().string(), about.times_ns.size(),
                              start, end, format_bytes(bytes)));
  }
}

/// Coarser, or as fine as they are: what was rounded does not come back.
nlohmann::json round_fields(double kb_per_frame, const std::filesystem::path& path, clip::StoredClip& stored,
                            Context& context) {
  const std::optional<container::Preview> preview = std::exchange(stored.preview, std::nullopt); // does not count
  clip::write_stored_clip(stored, path);
  const clip::Clip decoded = clip::read_clip(path);
  std::vector<clip::FieldRounding> usual;
  for (const clip::Layer& layer : decoded.layers) usual.push_back(clip::usual_rounding(layer.field.config));
  clip::store_fields(decoded, usual, stored);
  clip::write_stored_clip(stored, path);
  const auto bytes = static_cast<std::size_t>(std::filesystem::file_size(path));
  nlohmann::json rate;
  clip::store_fields(decoded, choose_rate(decoded, bytes, kb_per_frame, context, rate).fields, stored);
  stored.preview = preview;
  return rate;
}

void run_cut(const Options& options, Context& context) {
  require_input(options.input);
  const Companions companions = companions_of(options.companions);
  if (options.frames.empty() && companions.empty() && options.kb_per_frame == 0) {
    throw Error(ErrorCode::kUsage, "cut has nothing to do; give --frames, --kb-per-frame, or what to add: "
                                   "--flat-preview, --chapters, --tag");
  }
  if (!options.frames.empty() && FrameRange::parse(options.frames).step != 1) {
    throw Error(ErrorCode::kUsage,
                fmt::format("--frames {}: a cut takes all frames from A to B; give A:B", options.frames));
  }
  OutputFile out(options.output, context.shared.overwrite, {options.input, options.companions.chapters});
  const clip::StoredClip clip = clip::load_stored_clip(options.input);
  const std::vector<int> frames = frames_in_range(options.frames, clip.description.times_ns.size());
  clip::StoredClip piece =
      clip::cut(clip, static_cast<std::size_t>(frames.front()), static_cast<std::size_t>(frames.back()) + 1);
  nlohmann::json said{{"schema", "kinora.cut/1"}};
  if (options.kb_per_frame > 0) said["rate"] = round_fields(options.kb_per_frame, out.writing_path(), piece, context);
  clip::write_stored_clip(piece, out.writing_path());
  if (out.can_be_read_back()) add_companions(out.writing_path(), companions, context);
  finish(piece, out, std::move(said), context);
}

void run_join(const Options& options, Context& context) {
  require_input(options.input);
  require_input(options.second);
  OutputFile out(options.output, context.shared.overwrite, {options.input, options.second});
  const clip::StoredClip whole =
      clip::join(clip::load_stored_clip(options.input), clip::load_stored_clip(options.second));
  clip::write_stored_clip(whole, out.writing_path());
  finish(whole, out, {{"schema", "kinora.join/1"}}, context);
}

} // namespace

void add_cut(CLI::App& app, Context& context) {
  const auto options = std::make_shared<Options>();
  CLI::App& command = context.add_command(
      app, "cut", "Take some of a clip's frames, make it smaller, or add a preview, chapters and tags",
      "  kinora cut clip.mkv part.mkv --frames 30:60\n"
      "  kinora cut clip.mkv small.mkv --kb-per-frame 3\n"
      "  kinora cut clip.mkv film.mkv --flat-preview --tag TITLE=\"The chair\"",
      [options, &context] { run_cut(*options, context); });
  command.add_option("CLIP", options->input, "The clip to cut")->required()->type_name("FILE");
  command.add_option("OUT", options->output, "The clip to write; its frames keep their times")
      ->required()
      ->type_name("FILE");
  command.add_option("--frames", options->frames, "The frames to keep (all); counts from 0, B excluded")
      ->type_name("A:B");
  add_kb_per_frame_option(command, options->kb_per_frame);
  add_companion_options(command, options->companions);
  context.add_overwrite(command);
}

void add_join(CLI::App& app, Context& context) {
  const auto options = std::make_shared<Options>();
  CLI::App& command = context.add_command(app, "join", "Put pieces of one clip behind one another again",
                                          "  kinora join first.mkv second.mkv whole.mkv",
                                          [options, &context] { run_join(*options, context); });
  command.add_option("A", options->input, "The clip that comes first")->required()->type_name("FILE");
  command.add_option("B", options->second, "The clip that follows; a piece of the same clip")
      ->required()
      ->type_name("FILE");
  command.add_option("OUT", options->output, "The clip to write")->required()->type_name("FILE");
  context.add_overwrite(command);
}

} // namespace kinora::cli
