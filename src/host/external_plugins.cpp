#include <algorithm>
#include <cstdlib>

#include <dlfcn.h>
#include <fmt/format.h>

#include "core/error.h"
#include "core/module.h"
#include "host/plugin_table.h"

namespace kinora::host {
namespace fs = std::filesystem;

namespace {

const KinoraPlugin& load_library(const fs::path& path) {
  void* library = dlopen(fs::absolute(path).c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    const char* why = dlerror();
    throw Error(ErrorCode::kMissingComponent,
                fmt::format("{}: cannot be loaded ({})", path.string(), why != nullptr ? why : "no reason given"));
  }
  const auto entry = reinterpret_cast<KinoraPluginEntry>(dlsym(library, KINORA_PLUGIN_ENTRY));
  if (entry == nullptr)
    throw Error(ErrorCode::kMissingComponent,
                fmt::format("{}: no Kinora plugin (it exports no {})", path.string(), KINORA_PLUGIN_ENTRY));
  const KinoraPlugin* plugin = entry(KINORA_PLUGIN_ABI);
  if (plugin == nullptr)
    throw Error(ErrorCode::kMissingComponent, fmt::format("{}: does not work with version {} of the plugin interface",
                                                          path.string(), KINORA_PLUGIN_ABI));
  return *plugin;
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
    std::vector<fs::path> libraries;
    std::error_code error;
    for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
      if (entry->path().extension() == ".so") libraries.push_back(entry->path());
    std::sort(libraries.begin(), libraries.end());
    for (const fs::path& library : libraries) {
      try {
        table.add(load_library(library), library.string());
      } catch (const Error& problem) {
        progress.warn(fmt::format("plugin left out: {}", problem.what()));
      }
    }
  }
}

} // namespace kinora::host
