#include "host/isolated.h"

#include <cerrno>
#include <csignal>
#include <cstring>

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace kinora::host {
namespace {

using Clock = std::chrono::steady_clock;

[[noreturn]] void be_the_child(int out, std::span<const std::byte> answer, const std::function<void()>& work) {
  const rlimit no_core_file = {0, 0};
  setrlimit(RLIMIT_CORE, &no_core_file);
  for (const int fault : {SIGSEGV, SIGABRT, SIGBUS, SIGFPE, SIGILL, SIGINT, SIGTERM}) std::signal(fault, SIG_DFL);
  const int nowhere = open("/dev/null", O_RDWR);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) dup2(nowhere, stream);
  try {
    work();
  } catch (...) {
    _exit(1); // strangers throw whatever they like
  }
  for (std::size_t sent = 0; sent < answer.size();) {
    const ssize_t count = write(out, answer.data() + sent, answer.size() - sent);
    if (count <= 0) _exit(1);
    sent += static_cast<std::size_t>(count);
  }
  _exit(0);
}

/// How many bytes came before the end or the deadline; `late` says which.
std::size_t receive(int in, std::span<std::byte> answer, Clock::time_point deadline, bool& late) {
  std::size_t got = 0;
  while (got < answer.size()) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
    pollfd waiting = {in, POLLIN, 0};
    const int ready = left <= 0 ? 0 : poll(&waiting, 1, static_cast<int>(left));
    if (ready < 0 && errno == EINTR) continue;
    late = ready <= 0;
    if (late) return got;
    const ssize_t count = read(in, answer.data() + got, answer.size() - got);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return got;
    got += static_cast<std::size_t>(count);
  }
  return got;
}

} // namespace

Isolated run_isolated(std::span<std::byte> answer, const std::function<void()>& work, std::chrono::milliseconds limit) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return {false, std::string("no pipe to a child process: ") + std::strerror(errno)};
  const pid_t child = fork();
  if (child == 0) be_the_child(ends[1], answer, work);
  close(ends[1]);
  if (child < 0) {
    const std::string why = std::strerror(errno);
    close(ends[0]);
    return {false, "no child process: " + why};
  }
  bool late = false;
  const std::size_t got = receive(ends[0], answer, Clock::now() + limit, late);
  close(ends[0]);
  if (got < answer.size()) kill(child, SIGKILL);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (late) return {false, fmt::format("did not answer within {} s", std::chrono::duration<double>(limit).count())};
  if (got == answer.size()) return {true, {}};
  if (WIFSIGNALED(status) && WTERMSIG(status) != SIGKILL)
    return {false, fmt::format("crashed ({})", strsignal(WTERMSIG(status)))};
  return {false, "ended without an answer"};
}

} // namespace kinora::host
