#include "cli/interrupt.h"

#include <atomic>
#include <csignal>
#include <thread>

#include "cli/unfinished.h"
#include "core/error.h"

namespace kinora::cli {
namespace {

std::atomic<bool> stop{false};

[[noreturn]] void wait_for_signals(sigset_t signals) {
  while (true) {
    int number = 0;
    if (sigwait(&signals, &number) != 0) continue;
    if (stop.exchange(true)) remove_unfinished_and_exit(static_cast<int>(ErrorCode::kInterrupted));
  }
}

} // namespace

void handle_signals() {
  std::signal(SIGPIPE, SIG_IGN);
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr); // threads inherit this
  std::thread(wait_for_signals, signals).detach();
}

bool interrupted() { return stop.load(); }

} // namespace kinora::cli
