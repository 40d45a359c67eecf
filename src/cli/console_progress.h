// Progress for a person: a bar on a terminal, plain lines now and then elsewhere. Always on stderr.
#pragma once

#include <chrono>
#include <mutex>
#include <string>

#include "core/progress.h"

namespace kinora::cli {

enum class Verbosity { kQuiet, kNormal, kVerbose };

/// Cancelled by the signals of interrupt.h. Thread-safe: plugins speak from the threads that read.
class ConsoleProgress : public Progress {
public:
  ConsoleProgress();
  ~ConsoleProgress() override;

  void set_verbosity(Verbosity verbosity) { verbosity_ = verbosity; }
  Verbosity verbosity() const { return verbosity_; }

  void stage(const std::string& name, std::size_t total) override;
  void advance(std::size_t done, const std::string& detail) override;
  void warn(const std::string& sentence) override;
  bool cancelled() const override;

  /// A sentence that only -v shows.
  void detail(const std::string& sentence);
  /// Ends the bar's line, so that other text may follow.
  void finish();

private:
  using Clock = std::chrono::steady_clock;

  void draw_bar();

  std::recursive_mutex mutex_; ///< of all that follows; for one function calls another
  bool terminal_;
  bool color_;
  Verbosity verbosity_ = Verbosity::kNormal;
  std::string name_;
  std::string detail_;
  std::size_t total_ = 0;
  std::size_t done_ = 0;
  bool line_open_ = false;
  Clock::time_point stage_start_;
  Clock::time_point last_shown_;
};

/// True if stderr is a terminal that wants colour (NO_COLOR unset or empty, https://no-color.org).
bool color_wanted();

} // namespace kinora::cli
