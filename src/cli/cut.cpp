// kinora cut and kinora join: pieces of clips, without encoding again.
#include <memory>

#include <fmt/format.h>

#include "cli/clip_input.h"
#include "cli/commands.h"
#include "cli/output_file.h"
#include "cli/text.h"
#include "clip/clip_edit.h"
#include "core/error.h"
#include "core/frame_range.h"

namespace kinora::cli {
namespace {

struct Options {
  std::filesystem::path input;
  std::filesystem::path second; ///< of join
  std::filesystem::path output;
  std::string frames; ///< of cut
};

void write(const clip::StoredClip& clip, OutputFile& out, const char* schema, Context& context) {
  if (!clip.others.empty()) {
    context.progress.warn(fmt::format("{}: left out, since a clip does not need it: {}", out.path().string(),
                                      fmt::join(clip.others, ", ")));
  }
  clip::write_stored_clip(clip, out.writing_path());
  std::error_code ignored;
  const auto bytes = static_cast<std::size_t>(std::filesystem::file_size(out.writing_path(), ignored));
  out.commit();
  const clip::ClipDescription& about = clip.description;
  constexpr double kNanoseconds = 1e9;
  const double start = static_cast<double>(about.times_ns.front()) / kNanoseconds;
  const double end = static_cast<double>(about.times_ns.back()) / kNanoseconds;
  if (context.shared.json) {
    context.print_json({{"schema", schema},
                        {"output", out.path().string()},
                        {"frames", about.times_ns.size()},
                        {"start_s", start},
                        {"end_s", end},
                        {"bytes", bytes},
                        {"left_out", clip.others}});
  } else {
    context.print(fmt::format("{}: {} frames, {:.2f} to {:.2f} s, {}\n", out.path().string(), about.times_ns.size(),
                              start, end, format_bytes(bytes)));
  }
}

void run_cut(const Options& options, Context& context) {
  require_input(options.input);
  const FrameRange range = FrameRange::parse(options.frames);
  if (range.step != 1) {
    throw Error(ErrorCode::kUsage,
                fmt::format("--frames {}: a cut takes all frames from A to B; give A:B", options.frames));
  }
  OutputFile out(options.output, context.shared.overwrite, {options.input});
  const clip::StoredClip clip = clip::load_stored_clip(options.input);
  const std::vector<int> frames = frames_in_range(options.frames, clip.description.times_ns.size());
  write(clip::cut(clip, static_cast<std::size_t>(frames.front()), static_cast<std::size_t>(frames.back()) + 1), out,
        "kinora.cut/1", context);
}

void run_join(const Options& options, Context& context) {
  require_input(options.input);
  require_input(options.second);
  OutputFile out(options.output, context.shared.overwrite, {options.input, options.second});
  write(clip::join(clip::load_stored_clip(options.input), clip::load_stored_clip(options.second)), out, "kinora.join/1",
        context);
}

} // namespace

void add_cut(CLI::App& app, Context& context) {
  const auto options = std::make_shared<Options>();
  CLI::App& command = context.add_command(app, "cut", "Take some of a clip's frames into a clip of their own",
                                          "  kinora cut clip.mkv part.mkv --frames 30:60",
                                          [options, &context] { run_cut(*options, context); });
  command.add_option("CLIP", options->input, "The clip to cut")->required()->type_name("FILE");
  command.add_option("OUT", options->output, "The clip to write; its frames keep their times")
      ->required()
      ->type_name("FILE");
  command.add_option("--frames", options->frames, "The frames to keep; counts from 0, B excluded")
      ->required()
      ->type_name("A:B");
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
