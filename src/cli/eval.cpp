// kinora eval: a clip against the capture it was made from.
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "cli/capture_input.h"
#include "cli/clip_input.h"
#include "cli/commands.h"
#include "cli/output_file.h"
#include "cli/quality_text.h"
#include "evaluate/evaluate.h"

namespace kinora::cli {
namespace {

struct Options {
  std::filesystem::path clip;
  std::filesystem::path capture;
  std::filesystem::path report;
  CaptureReading reading;
};

void run(const Options& options, Context& context) {
  std::optional<OutputFile> file;
  if (!options.report.empty())
    file.emplace(options.report, context.shared.overwrite, std::vector{options.clip, options.capture});
  const player::Player player(open_clip(options.clip, context.progress));
  require_input(options.capture);
  evaluate::EvaluateOptions how;
  how.ground_truth = true;
  how.format = options.reading.format;
  how.format_options = host::parse_options(options.reading.options);
  const nlohmann::json report =
      evaluate::evaluate_against(options.capture, context.plugins(), player, how, context.progress);
  if (file) write_text(*file, report.dump(1) + "\n");
  if (context.shared.json) {
    context.print_json(report);
  } else {
    context.print(quality_table(report));
    if (file) context.print(fmt::format("All numbers: {}\n", options.report.string()));
  }
}

} // namespace

void add_eval(CLI::App& app, Context& context) {
  const auto options = std::make_shared<Options>();
  CLI::App& command = context.add_command(
      app, "eval", "Compare a clip with the capture it was made from",
      "  kinora eval clip.mkv --against capture/ --report quality.json\n"
      "Ground truth beside the capture (gt/, novel/, cameras.json) is compared too, if it is there.",
      [options, &context] { run(*options, context); });
  command.add_option("CLIP", options->clip, "The clip to judge")->required()->type_name("FILE");
  command.add_option("--against", options->capture, "The capture it was made from")->required()->type_name("CAPTURE");
  command.add_option("--report", options->report, "Write all numbers to this JSON file")->type_name("FILE");
  add_reading_options(command, options->reading);
  context.add_overwrite(command);
}

} // namespace kinora::cli
