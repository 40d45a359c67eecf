// Runs the program as a user does, and keeps what it said.
#pragma once

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>

#include <gtest/gtest.h>

#include "formats/sample_capture.h"

namespace kinora::test {

struct Said {
  int code = -1; ///< exit code; −1 if it died by a signal
  std::string out;
  std::string err;
};

inline std::string contents_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// A program under way. Its stderr is read line by line; its stdout lies in a file.
class Running {
public:
  Running(const fs::path& folder, std::vector<std::string> words, const std::string& out_path = {},
          const std::string& program = KINORA_PROGRAM)
      : out_path_(out_path.empty() ? (folder / "stdout.txt").string() : out_path), keeps_out_(out_path.empty()) {
    words.insert(words.begin(), program);
    std::vector<char*> argv;
    argv.reserve(words.size() + 1);
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    int ends[2];
    if (pipe(ends) != 0) throw std::runtime_error("no pipe");
    pid_ = fork();
    if (pid_ == 0) {
      const int out = open(out_path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
      dup2(out, STDOUT_FILENO);
      dup2(ends[1], STDERR_FILENO);
      close(ends[0]);
      close(ends[1]);
      execv(program.c_str(), argv.data());
      _exit(127);
    }
    close(ends[1]);
    err_end_ = ends[0];
  }
  Running(const Running&) = delete;
  Running& operator=(const Running&) = delete;
  ~Running() { close(err_end_); }

  /// Returns when stderr has said `word`, or has ended; whether it said it.
  bool wait_for(const std::string& word) {
    while (err_.find(word) == std::string::npos) {
      if (!read_some()) return false;
    }
    return true;
  }
  void interrupt() const { kill(pid_, SIGINT); }
  void kill_at_once() const { kill(pid_, SIGKILL); }
  /// Whether it has ended by itself; finish() is still due.
  bool ended() const {
    siginfo_t info{};
    return waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED | WNOHANG | WNOWAIT) == 0 && info.si_pid == pid_;
  }
  Said finish() {
    while (read_some()) {
    }
    int status = 0;
    waitpid(pid_, &status, 0);
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, keeps_out_ ? contents_of(out_path_) : "", err_};
  }

private:
  bool read_some() {
    char buffer[4096];
    const ssize_t count = read(err_end_, buffer, sizeof buffer);
    if (count <= 0) return false;
    err_.append(buffer, static_cast<std::size_t>(count));
    return true;
  }

  std::string out_path_;
  bool keeps_out_; ///< false: stdout is a device, which may have no end
  pid_t pid_ = -1;
  int err_end_ = -1;
  std::string err_;
};

/// Everything below a folder, as paths within it; sorted.
inline std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_directory()) names.push_back(entry.path().lexically_relative(folder).string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

inline Said run_kinora(const TemporaryFolder& folder, const std::vector<std::string>& words) {
  return Running(folder.path(), words).finish();
}

/// The error is one line that begins with "kinora: " and holds `word`; warnings may stand before it.
inline void expect_error(const Said& said, int code, const std::string& word) {
  EXPECT_EQ(said.code, code) << said.err;
  const std::size_t start = said.err.rfind("kinora: ");
  ASSERT_NE(start, std::string::npos) << said.err;
  const std::string line = said.err.substr(start);
  EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 1) << said.err;
  EXPECT_NE(line.find(word), std::string::npos) << said.err;
}

} // namespace kinora::test
