#include "cli/live_device.h"

#include <fstream>
#include <sstream>

#include "cli/clip_input.h"
#include "cli/interrupt.h"

namespace kinora::cli {

void add_live_options(CLI::App& command, LiveOptions& options, const std::string& description) {
  auto* live = command.add_flag("--live", options.live, description);
  command
      .add_option("--live-script", options.script,
                  "What goes wrong with the camera, a line each: stall BEGIN SECONDS, drop BEGIN SECONDS, "
                  "disconnect BEGIN")
      ->needs(live)
      ->type_name("FILE");
}

std::shared_ptr<host::SimulatedDevice> make_device(const LiveOptions& options, double max_age) {
  if (!options.live) return nullptr;
  std::vector<host::DeviceFault> faults;
  if (!options.script.empty()) {
    require_input(options.script);
    std::ostringstream text;
    text << std::ifstream(options.script).rdbuf();
    faults = host::parse_device_faults(text.str(), options.script.string());
  }
  return std::make_shared<host::SimulatedDevice>(std::move(faults), max_age, host::DeviceClock::steady(), interrupted);
}

} // namespace kinora::cli
