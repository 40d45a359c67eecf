// kinora play: a clip in a window.
#include <memory>

#include "cli/clip_window.h"
#include "cli/commands.h"

namespace kinora::cli {

void add_play(CLI::App& app, Context& context) {
  const auto file = std::make_shared<std::string>();
  CLI::App& command = context.add_command(app, "play", "Play a clip in a window, and turn it around",
                                          "  kinora play clip.mkv\n  kinora play http://127.0.0.1:8080/clip.mkv",
                                          [file, &context] { show_in_window(*file, context); });
  command.add_option("CLIP", *file, "The clip to play, or its address; others can be dropped onto the window")
      ->required()
      ->type_name("FILE|URL");
}

} // namespace kinora::cli
