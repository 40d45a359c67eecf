// kinora probe: which format recognises an input, how surely, and why.
#include <memory>
#include <system_error>

#include <fmt/format.h>

#include "cli/clip_input.h"
#include "cli/commands.h"
#include "cli/text.h"
#include "core/error.h"
#include "host/frame_reader.h"

namespace kinora::cli {
namespace {

using Json = nlohmann::json;

struct Answer {
  std::string name;
  int confidence;
  std::string reason;
  std::string origin;
};

/// Whether the surest format can open what it recognised: "it is X but broken" is worth more than a high score.
std::string problem_of(const Answer& best, const std::filesystem::path& input, const host::PluginTable& plugins) {
  constexpr int kSureEnough = 50;
  if (best.origin.empty() || best.confidence < kSureEnough) return {};
  try {
    const host::FrameReader reader(plugins.find(best.name), input, {});
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

// Clips are no capture format; whether a file is one is asked of their own reader.
std::optional<Answer> as_clip(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return std::nullopt;
  try {
    clip::read_clip(path);
    return Answer{"kinora-clip", 100, "a clip of Kinora, whole", ""};
  } catch (const Error& error) {
    return Answer{"kinora-clip", error.code() == ErrorCode::kNotRecognised ? 0 : 90, error.what(), ""};
  }
}

void run(const std::filesystem::path& input, Context& context) {
  require_input(input);
  std::vector<Answer> answers;
  if (const auto clip = as_clip(input)) answers.push_back(*clip);
  for (const host::ProbeScore& score : context.plugins().probe(input)) {
    answers.push_back({score.format->name, score.confidence, score.reason, score.origin});
  }
  std::stable_sort(answers.begin(), answers.end(),
                   [](const Answer& a, const Answer& b) { return a.confidence > b.confidence; });
  if (answers.empty() || answers.front().confidence == 0) {
    context.plugins().recognise(input); // throws, and says what a capture is, or which plugin is missing
  }
  const std::string problem = problem_of(answers.front(), input, context.plugins());
  if (context.shared.json) {
    Json out = {{"schema", "kinora.probe/1"}, {"path", input.string()}, {"formats", Json::array()}};
    for (const Answer& answer : answers) {
      out["formats"].push_back({{"name", answer.name},
                                {"confidence", answer.confidence},
                                {"reason", answer.reason},
                                {"origin", answer.origin.empty() ? "built-in" : answer.origin}});
    }
    out["problem"] = problem.empty() ? Json(nullptr) : Json(problem);
    context.print_json(out);
    return;
  }
  Table table({"format", "sure", "why"});
  for (const Answer& answer : answers) {
    table.add({answer.name, fmt::format("{} %", answer.confidence), answer.reason});
  }
  context.print(table.str());
  if (!problem.empty()) context.print(fmt::format("It is {} but broken: {}\n", answers.front().name, problem));
}

} // namespace

void add_probe(CLI::App& app, Context& context) {
  const auto input = std::make_shared<std::filesystem::path>();
  CLI::App& command = context.add_command(app, "probe", "Which format recognises an input, how surely, and why",
                                          "  kinora probe capture/\n  kinora probe capture/ --json",
                                          [input, &context] { run(*input, context); });
  command.add_option("FILE", *input, "A file or folder")->required()->type_name("PATH");
}

} // namespace kinora::cli
