// A clip in a window.
#pragma once

#include <functional>
#include <string>

#include "cli/context.h"
#include "core/se3.h"

namespace kinora::cli {

/// Throws Error(kMissingComponent) if no window can be opened here.
void require_window();

/// Shows the clip of a path or an address, also one that still grows, until its window is closed. To be called by the
/// program's first thread. `seen_from`, if any, is told the pose of the window's camera, camera to world, for every
/// picture. Throws Error, as opening and reading a clip do, and kMissingComponent.
void show_in_window(const std::string& clip, Context& context,
                    const std::function<void(const SE3& camera_to_world)>& seen_from = {});

} // namespace kinora::cli
