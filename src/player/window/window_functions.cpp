#include "player/window/window_functions.h"

#include "core/module.h"

namespace kinora::player::window {

const WindowFunctions& window_functions() {
  using Entry = const WindowFunctions* (*)();
  static const WindowFunctions* const functions =
      reinterpret_cast<Entry>(module_symbol("window", "kinora_functions", "to open a window"))();
  return *functions;
}

} // namespace kinora::player::window
