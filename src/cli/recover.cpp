// kinora recover and kinora validate: what is sound of a damaged file into a new one, and whether all of a file is.
#include <algorithm>
#include <memory>

#include <fmt/format.h>

#include "cli/clip_input.h"
#include "cli/commands.h"
#include "cli/file_check.h"
#include "cli/output_file.h"
#include "cli/text.h"
#include "clip/clip_io.h"
#include "clip/codec_ids.h"
#include "container/reader.h"
#include "container/recovery.h"
#include "core/error.h"

namespace kinora::cli {
namespace {

using Json = nlohmann::json;

struct Options {
  std::filesystem::path input;
  std::filesystem::path output;
};

std::vector<std::string> losses_of(const container::Recovery& recovery) {
  std::vector<std::string> lost = recovery.lost;
  for (const container::Damage& damage : recovery.damage.entries())
    lost.push_back(fmt::format("bytes {} to {}: {}", damage.offset, damage.end, damage.why));
  if (recovery.damage.further() > 0)
    lost.push_back(
        fmt::format("{} further places, {} bytes in all", recovery.damage.further(), recovery.damage.bytes()));
  if (!recovery.finished) lost.emplace_back("whatever came behind the end: the file was not finished or is cut short");
  return lost;
}

void run_recover(const Options& options, Context& context) {
  require_input(options.input);
  OutputFile out(options.output, context.shared.overwrite, {options.input});
  context.progress.stage("recovering", 0);
  const container::Recovery recovery = container::recover(options.input, out.writing_path(), context.progress);
  if (container::Reader(out.writing_path()).tag(container::kKindTag) == clip::kLiveClipKind)
    clip::write_clip(clip::read_clip(out.writing_path()), out.writing_path()); // its last update becomes a clip
  const FileCheck check = check_file(out.writing_path(), context.progress);
  out.commit();
  const std::vector<std::string> lost = losses_of(recovery);
  if (context.shared.json) {
    context.print_json({{"schema", "kinora.recover/1"},
                        {"output", options.output.string()},
                        {"kind", check.kind},
                        {"payloads", recovery.payloads},
                        {"blocks", recovery.blocks},
                        {"lost", lost},
                        {"still_damaged", check.damage}});
    return;
  }
  std::string text = fmt::format("{}: a {} with {} checked payloads and {} pictures or sounds\n",
                                 options.output.string(), check.kind, recovery.payloads, recovery.blocks);
  if (!lost.empty()) text += "Lost:\n";
  for (const std::string& sentence : lost) text += "  " + sentence + "\n";
  if (!check.damage.empty()) text += "Not whole in what was saved:\n";
  for (const std::string& sentence : check.damage) text += "  " + sentence + "\n";
  if (lost.empty() && check.damage.empty()) text += "Nothing was lost.\n";
  context.print(text);
}

void run_validate(const std::filesystem::path& input, Context& context) {
  require_input(input);
  context.progress.stage("checking", 0);
  const FileCheck check = check_file(input, context.progress);
  if (context.shared.json) {
    context.print_json({{"schema", "kinora.validate/1"},
                        {"path", input.string()},
                        {"kind", check.kind},
                        {"sound", check.damage.empty()},
                        {"damage", check.damage}});
  } else if (check.damage.empty()) {
    context.print(fmt::format("{}: a sound {}\n", input.string(), check.kind));
  } else {
    for (const std::string& sentence : check.damage) context.print(sentence + "\n");
  }
  context.flush();
  throw_if_damaged(check, input);
}

} // namespace

void add_recover(CLI::App& app, Context& context) {
  const auto options = std::make_shared<Options>();
  CLI::App& command = context.add_command(app, "recover", "Save what is sound of a damaged or unfinished file",
                                          "  kinora recover broken.mkv saved.mkv",
                                          [options, &context] { run_recover(*options, context); });
  command.add_option("INPUT", options->input, "The damaged clip or recording")->required()->type_name("FILE");
  command.add_option("OUTPUT", options->output, "The file to write")->required()->type_name("FILE");
  context.add_overwrite(command);
}

void add_validate(CLI::App& app, Context& context) {
  const auto input = std::make_shared<std::filesystem::path>();
  CLI::App& command =
      context.add_command(app, "validate", "Check every byte of a clip or recording", "  kinora validate clip.mkv",
                          [input, &context] { run_validate(*input, context); });
  command.add_option("FILE", *input, "A clip or a recording")->required()->type_name("FILE");
}

} // namespace kinora::cli
