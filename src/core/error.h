// The one exception type of Kinora, and the exit codes that the command line documents.
#pragma once

#include <stdexcept>
#include <string>

namespace kinora {

/// What went wrong, as the command line's exit code.
enum class ErrorCode {
  kFailure = 1,          ///< anything not named below
  kUsage = 2,            ///< the call's own words are wrong
  kNotRecognised = 3,    ///< no format knows this input
  kCorruptInput = 4,     ///< a known format, but damaged or absurd
  kUnwritableOutput = 5, ///< the output cannot be created or written to its end
  kMissingComponent = 6, ///< a plugin or library is not there
  kInterrupted = 130     ///< the user stopped it
};

/// Thrown by every room. `what()` is one sentence that names the file, the place in it and the remedy.
class Error : public std::runtime_error {
public:
  Error(ErrorCode code, const std::string& sentence) : std::runtime_error(sentence), code_(code) {}
  ErrorCode code() const { return code_; }
  int exit_code() const { return static_cast<int>(code_); }

private:
  ErrorCode code_;
};

} // namespace kinora
