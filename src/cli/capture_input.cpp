#include "cli/capture_input.h"

#include "cli/clip_input.h"

namespace kinora::cli {

void add_reading_options(CLI::App& command, CaptureReading& reading) {
  command.add_option("--format", reading.format, "Read the capture with this format (see kinora formats)")
      ->type_name("NAME");
  command.add_option("-O", reading.options, "An option of the format that reads (see kinora formats); may be repeated")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
}

void require_capture(const std::filesystem::path& capture, Context& context) {
  if (!context.plugins().is_device(capture)) require_input(capture);
}

host::FrameReader open_frames(const std::filesystem::path& capture, const CaptureReading& reading, Context& context) {
  const host::PluginTable& plugins = context.plugins();
  const host::Options options = host::parse_options(reading.options);
  return {reading.format.empty() ? plugins.recognise(capture) : plugins.find(reading.format), capture, options};
}

} // namespace kinora::cli
