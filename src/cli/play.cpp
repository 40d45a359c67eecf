// kinora play: a clip in a window.
#include <memory>

#include "cli/clip_input.h"
#include "cli/commands.h"
#include "cli/interrupt.h"
#include "player/window/viewer.h"

namespace kinora::cli {
namespace {

void run(const std::filesystem::path& file, Context& context) {
  namespace window = player::window;
  const auto open = [&context](const std::filesystem::path& clip) {
    return std::make_shared<const player::Player>(open_clip(clip, context.progress));
  };
  const window::WindowFunctions& functions = window::window_functions();
  window::Viewer viewer(file, open, std::filesystem::current_path(), interrupted);
  const auto [width, height] = viewer.wanted_size();
  functions.show_window(viewer, width, height);
  const std::string left = viewer.finish();
  if (!left.empty() && !context.shared.quiet && !context.shared.json) context.print(left + "\n");
}

} // namespace

void add_play(CLI::App& app, Context& context) {
  const auto file = std::make_shared<std::filesystem::path>();
  CLI::App& command = context.add_command(app, "play", "Play a clip in a window, and turn it around",
                                          "  kinora play clip.mkv", [file, &context] { run(*file, context); });
  command.add_option("CLIP", *file, "The clip to play; others can be dropped onto the window")
      ->required()
      ->type_name("FILE");
}

} // namespace kinora::cli
