// Ctrl-C and SIGTERM: the first asks the work to stop, the second ends the program at once.
#pragma once

#include <filesystem>

namespace kinora::cli {

/// Installs the handlers of SIGINT and SIGTERM; a closed pipe becomes a write error instead of a signal.
void handle_signals();

/// True once the user asked to stop. Any thread.
bool interrupted();

/// The unfinished file that a second signal removes before the program ends; an empty path forgets it. One at a time.
void remember_unfinished(const std::filesystem::path& path);

} // namespace kinora::cli
