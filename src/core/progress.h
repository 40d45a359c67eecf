// How a library tells the caller what it is doing, and how the caller stops it. Libraries never print.
#pragma once

#include <cstddef>
#include <string>

namespace kinora {

/// Receives progress and warnings. The default drops everything and never cancels.
/// Called from one thread at a time.
class Progress {
public:
  virtual ~Progress() = default;
  /// A stage starts; `total` steps, 0 if unknown.
  virtual void stage(const std::string& /*name*/, std::size_t /*total*/) {}
  /// `done` steps of the current stage are finished. `detail` is one short phrase, or empty.
  virtual void advance(std::size_t /*done*/, const std::string& /*detail*/) {}
  /// One sentence that a person should read; the work goes on.
  virtual void warn(const std::string& /*sentence*/) {}
  /// True when the user wants to stop. May be called from any thread.
  virtual bool cancelled() const { return false; }
  /// Throws Error(kInterrupted) when cancelled.
  void check() const;
};

} // namespace kinora
