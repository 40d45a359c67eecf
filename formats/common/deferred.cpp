#include "common/deferred.h"

#include <algorithm>
#include <cstring>
#include <span>
#include <system_error>

#include "core/module.h"

namespace kinora::formats {

const KinoraFormat& format_in(const FormatModule& module) {
  const auto entry =
      reinterpret_cast<KinoraPluginEntry>(module_symbol(module.name, KINORA_PLUGIN_ENTRY, module.purpose));
  if (const KinoraPlugin* plugin = entry(KINORA_PLUGIN_ABI); plugin != nullptr) {
    const std::span formats(plugin->formats, plugin->format_count);
    const auto found = std::ranges::find_if(
        formats, [&](const KinoraFormat* format) { return std::strcmp(format->name, module.format) == 0; });
    if (found != formats.end()) return **found;
  }
  throw Error(ErrorCode::kMissingComponent, module_path(module.name).string() +
                                                " belongs to another version of Kinora; install the program and its "
                                                "modules together");
}

std::string deferred_description(const FormatModule& module, const char* description) {
  const std::filesystem::path path = module_path(module.name);
  std::error_code ignored;
  if (std::filesystem::exists(path, ignored)) return description;
  return std::string(description) + " (not available: " + path.string() + " is not installed)";
}

} // namespace kinora::formats
