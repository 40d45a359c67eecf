#include "cli/console_progress.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include <fmt/format.h>
#include <unistd.h>

#include "cli/interrupt.h"

namespace kinora::cli {
namespace {

constexpr int kBarWidth = 24;
constexpr std::size_t kLineWidth = 79;
constexpr std::chrono::milliseconds kRedraw{100};
constexpr std::chrono::seconds kPlainLine{10};

// A progress line that cannot be shown is no reason to stop the work.
void put(const std::string& text) {
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fflush(stderr);
}

} // namespace

bool color_wanted() {
  const char* no_color = std::getenv("NO_COLOR");
  return isatty(STDERR_FILENO) != 0 && (no_color == nullptr || *no_color == '\0');
}

ConsoleProgress::ConsoleProgress() : terminal_(isatty(STDERR_FILENO) != 0), color_(color_wanted()) {}

ConsoleProgress::~ConsoleProgress() { finish(); }

void ConsoleProgress::stage(const std::string& name, std::size_t total) {
  const std::lock_guard lock(mutex_);
  finish();
  name_ = name;
  detail_.clear();
  total_ = total;
  done_ = 0;
  stage_start_ = last_shown_ = Clock::now();
  if (verbosity_ == Verbosity::kQuiet) return;
  if (terminal_) {
    draw_bar();
  } else {
    put(fmt::format("{}\n", name_));
  }
}

void ConsoleProgress::advance(std::size_t done, const std::string& detail) {
  const std::lock_guard lock(mutex_);
  done_ = done;
  detail_ = detail;
  if (verbosity_ == Verbosity::kQuiet) return;
  const auto now = Clock::now();
  if (terminal_) {
    if (now - last_shown_ < kRedraw && done_ != total_) return;
    last_shown_ = now;
    draw_bar();
    return;
  }
  if (now - last_shown_ < kPlainLine) return;
  last_shown_ = now;
  put(total_ > 0 ? fmt::format("  {}: {} of {}{}{}\n", name_, done_, total_, detail_.empty() ? "" : ", ", detail_)
                 : fmt::format("  {}: {}{}{}\n", name_, done_, detail_.empty() ? "" : ", ", detail_));
}

void ConsoleProgress::draw_bar() {
  std::string line;
  if (total_ > 0) {
    const double share = std::min(1.0, static_cast<double>(done_) / static_cast<double>(total_));
    const int filled = static_cast<int>(share * kBarWidth);
    line = fmt::format("{:<28.28} [{:=>{}}{:>{}}] {:3.0f} %", name_, "", filled, "", kBarWidth - filled, share * 100);
    const double elapsed = std::chrono::duration<double>(Clock::now() - stage_start_).count();
    if (share > 0.02 && share < 1 && elapsed > 2) line += fmt::format(" {:.0f} s left", elapsed * (1 - share) / share);
  } else {
    line = fmt::format("{:<28.28} {}", name_, done_);
  }
  if (!detail_.empty()) line += " " + detail_;
  if (line.size() > kLineWidth) line.resize(kLineWidth);
  put("\r\x1b[K" + line);
  line_open_ = true;
}

void ConsoleProgress::warn(const std::string& sentence) {
  const std::lock_guard lock(mutex_);
  if (verbosity_ == Verbosity::kQuiet) return;
  finish();
  put(fmt::format("{}warning:{} {}\n", color_ ? "\x1b[33m" : "", color_ ? "\x1b[0m" : "", sentence));
}

void ConsoleProgress::detail(const std::string& sentence) {
  const std::lock_guard lock(mutex_);
  if (verbosity_ != Verbosity::kVerbose) return;
  finish();
  put(sentence + "\n");
}

void ConsoleProgress::finish() {
  const std::lock_guard lock(mutex_);
  if (!line_open_) return;
  put("\n");
  line_open_ = false;
}

bool ConsoleProgress::cancelled() const { return interrupted(); }

} // namespace kinora::cli
