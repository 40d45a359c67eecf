// A clip in a window.
#pragma once

#include <string>

#include "cli/context.h"

namespace kinora::cli {

/// Throws Error(kMissingComponent) if no window can be opened here.
void require_window();

/// Shows the clip of a path or an address, also one that still grows, until its window is closed. To be called by the
/// program's first thread. Throws Error, as opening and reading a clip do, and kMissingComponent.
void show_in_window(const std::string& clip, Context& context);

} // namespace kinora::cli
