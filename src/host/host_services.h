// What the host gives to external plugins: a way to speak, memory, files and progress (KinoraHost).
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "kinora/plugin.h"

namespace kinora::host {

/// Who hears plugins. Called from any thread, one call at a time.
struct PluginListener {
  std::function<void(const std::string& sentence, bool is_warning)> log;
  std::function<bool(std::uint64_t done, std::uint64_t total)> progress; ///< true: stop
};

/// Replaces the listener of the process; functions that are empty hear nothing, and never stop. Thread-safe.
void set_plugin_listener(PluginListener listener);

/// For KinoraPluginHostEntry.
const KinoraHost& host_services();

} // namespace kinora::host
