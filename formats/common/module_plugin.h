// What a module (common/deferred.h) exports.
#pragma once

#include <cstdint>

#include "kinora/plugin.h"

namespace kinora::formats {

/// A plugin of these formats, for the function kinora_plugin; NULL for a host of another version.
template <const KinoraFormat&... formats> const KinoraPlugin* module_plugin(std::uint32_t host_abi_version) {
  static const KinoraFormat* const list[] = {&formats...};
  static const KinoraPlugin plugin = {sizeof(KinoraPlugin), KINORA_PLUGIN_ABI, "module", "", list, sizeof...(formats)};
  return host_abi_version == KINORA_PLUGIN_ABI ? &plugin : nullptr;
}

} // namespace kinora::formats
