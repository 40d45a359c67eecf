// kinora formats: the formats that can be read and written, and by whom.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/commands.h"
#include "cli/export_options.h"
#include "cli/text.h"

namespace kinora::cli {
namespace {

using Json = nlohmann::json;

/// Those that the format declares, and those that kinora convert has for all of its kind.
std::vector<KinoraOption> options_of(const KinoraFormat& format) {
  std::vector<KinoraOption> options = export_options(format);
  options.insert(options.end(), format.options, format.options + format.option_count);
  return options;
}

Json options_json(const KinoraFormat& format) {
  Json out = Json::array();
  for (const KinoraOption& option : options_of(format)) {
    out.push_back(
        {{"name", option.name}, {"type", option.type}, {"default", option.default_value}, {"help", option.help}});
  }
  return out;
}

void run_json(Context& context) {
  Json out = {{"schema", "kinora.formats/1"}, {"formats", Json::array()}};
  for (const host::FormatEntry& entry : context.plugins().formats()) {
    out["formats"].push_back({{"name", entry.format->name},
                              {"description", entry.format->description},
                              {"extensions", entry.format->extensions},
                              {"capabilities", host::capability_names(*entry.format)},
                              {"origin", entry.origin},
                              {"installed", entry.installed()},
                              {"options", options_json(*entry.format)}});
  }
  context.print_json(out);
}

void run(Context& context) {
  if (context.shared.json) {
    run_json(context);
    return;
  }
  Table table({"format", "what", "can", "from"});
  std::string options;
  for (const host::FormatEntry& entry : context.plugins().formats()) {
    const KinoraFormat& format = *entry.format;
    table.add({format.name,
               entry.installed() ? format.description : fmt::format("{} (not installed)", format.description),
               fmt::format("{}", fmt::join(host::capability_names(format), " ")), entry.origin});
    for (const KinoraOption& option : options_of(format)) {
      options += fmt::format("  {}: -O {}={}  {}\n", format.name, option.name, option.default_value, option.help);
    }
  }
  context.print(table.str());
  if (!options.empty()) context.print("Options with their defaults:\n" + options);
}

} // namespace

void add_formats(CLI::App& app, Context& context) {
  context.add_command(app, "formats", "The formats that can be read and written",
                      "  kinora formats\n  kinora formats --json --plugin-dir my-plugins/",
                      [&context] { run(context); });
}

} // namespace kinora::cli
