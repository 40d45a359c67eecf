// The module window: what it exports.
#include "player/window/window_functions.h"

extern "C" const kinora::player::window::WindowFunctions* kinora_functions() {
  static constexpr kinora::player::window::WindowFunctions functions = {
      .show_window = kinora::player::window::show, .require_display = kinora::player::window::require_display};
  return &functions;
}
