// Ctrl-C and SIGTERM: the first asks the work to stop, the second ends the program at once.
#pragma once

namespace kinora::cli {

/// From now on a thread of its own waits for SIGINT and SIGTERM, so that it may do what a signal handler must not: a
/// second one removes what is unfinished (unfinished.h). A closed pipe becomes a write error instead of a signal. To be
/// called by the first thread before there are others. Throws std::system_error.
void handle_signals();

/// True once the user asked to stop. Any thread.
bool interrupted();

} // namespace kinora::cli
