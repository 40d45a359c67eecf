// kinora play: a clip in a window.
#include <memory>

#include "cli/clip_input.h"
#include "cli/commands.h"
#include "cli/interrupt.h"
#include "player/http/http_functions.h"
#include "player/window/viewer.h"

namespace kinora::cli {
namespace {

namespace window = player::window;

std::unique_ptr<window::ClipFeed> open(const std::string& clip) {
  if (player::is_address(clip)) {
    return std::make_unique<window::ClipFeed>(player::http_functions().open_address(clip, interrupted));
  }
  require_clip(clip);
  return std::make_unique<window::ClipFeed>(std::make_unique<container::FileSource>(clip));
}

void run(const std::string& file, Context& context) {
  const window::WindowFunctions& functions = window::window_functions();
  window::Viewer viewer(file, open, std::filesystem::current_path(), interrupted);
  const auto [width, height] = viewer.wanted_size();
  functions.show_window(viewer, width, height);
  const std::string left = viewer.finish();
  if (!left.empty() && !context.shared.quiet && !context.shared.json) context.print(left + "\n");
}

} // namespace

void add_play(CLI::App& app, Context& context) {
  const auto file = std::make_shared<std::string>();
  CLI::App& command = context.add_command(app, "play", "Play a clip in a window, and turn it around",
                                          "  kinora play clip.mkv\n  kinora play http://127.0.0.1:8080/clip.mkv",
                                          [file, &context] { run(*file, context); });
  command.add_option("CLIP", *file, "The clip to play, or its address; others can be dropped onto the window")
      ->required()
      ->type_name("FILE|URL");
}

} // namespace kinora::cli
