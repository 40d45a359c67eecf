#include <algorithm>
#include <cstdlib>

#include <fmt/format.h>

#include "core/error.h"
#include "core/module.h"
#include "host/external_plugin.h"
#include "host/plugin_table.h"

namespace kinora::host {
namespace fs = std::filesystem;

namespace {

/// What a folder of plugins holds: folders with a plugin.json, and libraries that lie there without one.
std::vector<fs::path> plugins_in(const fs::path& folder) {
  std::vector<fs::path> found;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    std::error_code ignored;
    if (const fs::path manifest = entry->path() / "plugin.json"; fs::is_regular_file(manifest, ignored))
      found.push_back(manifest);
    else if (entry->path().extension() == ".so")
      found.push_back(entry->path());
  }
  if (fs::is_regular_file(folder / "plugin.json", error)) found.push_back(folder / "plugin.json");
  std::sort(found.begin(), found.end());
  return found;
}

/// A library beside folder/plugin.json is that plugin's own.
bool belongs_to_manifest(const fs::path& library, const std::vector<fs::path>& found) {
  return std::ranges::find(found, library.parent_path() / "plugin.json") != found.end();
}

} // namespace

std::vector<fs::path> plugin_folders(std::span<const fs::path> extra) {
  std::vector<fs::path> folders(extra.begin(), extra.end());
  if (const char* variable = std::getenv("KINORA_PLUGIN_PATH"); variable != nullptr) {
    for (std::string_view rest = variable; !rest.empty();) {
      const std::size_t end = std::min(rest.find(':'), rest.size());
      if (end > 0) folders.emplace_back(rest.substr(0, end));
      rest.remove_prefix(std::min(end + 1, rest.size()));
    }
  }
  if (const fs::path modules = module_folder(); !modules.empty()) folders.push_back(modules / "plugins");
  return folders;
}

void load_external_plugins(PluginTable& table, std::span<const fs::path> folders, Progress& progress) {
  for (const fs::path& folder : folders) {
    const std::vector<fs::path> found = plugins_in(folder);
    for (const fs::path& path : found) {
      try {
        if (path.filename() == "plugin.json")
          table.add(std::make_shared<const ExternalPlugin>(read_manifest(path)));
        else if (!belongs_to_manifest(path, found))
          table.add(load_library(path), path.string());
      } catch (const Error& problem) {
        progress.warn(fmt::format("plugin left out: {}", problem.what()));
      }
    }
  }
}

} // namespace kinora::host
