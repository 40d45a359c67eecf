#include "cli/interrupt.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <csignal>
#include <string>

#include <unistd.h>

#include "core/error.h"

namespace kinora::cli {
namespace {

// Everything that a handler touches is lock-free and needs no allocation.
std::atomic<bool> stop{false};
std::atomic<bool> unfinished_known{false};
std::array<char, 4096> unfinished_path{};

void on_signal(int /*number*/) {
  if (!stop.exchange(true)) return;
  if (unfinished_known.load()) ::unlink(unfinished_path.data());
  ::_exit(static_cast<int>(ErrorCode::kInterrupted));
}

} // namespace

void handle_signals() {
  struct sigaction action {};
  action.sa_handler = on_signal;
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_RESTART;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  action.sa_handler = SIG_IGN;
  sigaction(SIGPIPE, &action, nullptr);
}

bool interrupted() { return stop.load(); }

void remember_unfinished(const std::filesystem::path& path) {
  unfinished_known.store(false);
  const std::string text = path.string();
  if (text.empty() || text.size() >= unfinished_path.size()) return;
  std::copy(text.begin(), text.end(), unfinished_path.begin());
  unfinished_path[text.size()] = '\0';
  unfinished_known.store(true);
}

} // namespace kinora::cli
