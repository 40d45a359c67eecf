// What lies over the picture, in Dear ImGui's words: the bar below and the box in the corner.
#pragma once

#include "player/window/window_functions.h"

namespace kinora::player::window {

/// Between ImGui::NewFrame() and ImGui::Render().
void draw_panel(Shown& shown, const Panel& panel);

} // namespace kinora::player::window
