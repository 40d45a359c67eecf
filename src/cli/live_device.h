// --live and --live-script: a capture as from a camera.
#pragma once

#include <filesystem>
#include <memory>

#include <CLI/CLI.hpp>

#include "host/simulated_device.h"

namespace kinora::cli {

struct LiveOptions {
  bool live = false;
  std::filesystem::path script; ///< of faults; empty: none
};

void add_live_options(CLI::App& command, LiveOptions& options, const std::string& description);

/// Null without --live. Ctrl-C ends the capture. Throws Error: kFailure if the script cannot be read, kCorruptInput if
/// it is none.
std::shared_ptr<host::SimulatedDevice> make_device(const LiveOptions& options, double max_age);

} // namespace kinora::cli
