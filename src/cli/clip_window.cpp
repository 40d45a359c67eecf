#include "cli/clip_window.h"

#include <memory>

#include "cli/clip_input.h"
#include "cli/interrupt.h"
#include "player/http/http_functions.h"
#include "player/window/viewer.h"

namespace kinora::cli {
namespace window = player::window;
namespace {

std::unique_ptr<player::ClipFeed> open(const std::string& clip) {
  if (player::is_address(clip)) {
    return std::make_unique<player::ClipFeed>(player::http_functions().open_address(clip, interrupted));
  }
  require_clip(clip);
  return std::make_unique<player::ClipFeed>(std::make_unique<container::FileSource>(clip));
}

} // namespace

void require_window() { window::window_functions().require_display(); }

void show_in_window(const std::string& clip, Context& context,
                    const std::function<void(const SE3& camera_to_world)>& seen_from) {
  const window::WindowFunctions& functions = window::window_functions();
  window::Viewer viewer(clip, open, std::filesystem::current_path(), interrupted);
  viewer.tell_camera(seen_from);
  const auto [width, height] = viewer.wanted_size();
  functions.show_window(viewer, width, height);
  const std::string left = viewer.finish();
  if (!left.empty() && !context.shared.quiet && !context.shared.json) context.print(left + "\n");
}

} // namespace kinora::cli
