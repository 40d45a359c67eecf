// A clip that is written again and again while it grows, and pictures of it.
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>

#include "cli/context.h"
#include "cli/output_file.h"
#include "clip/clip.h"

namespace kinora::cli {

/// At any moment there is a whole file under the name, from the first write on: each stands in for the one before in
/// one step. Not thread-safe.
class GrowingClipFile {
public:
  /// `first`: of that name, not committed yet.
  explicit GrowingClipFile(OutputFile& first) : first_(first) {}
  /// Throws Error(kUnwritableOutput): what was written before stays.
  void write(const clip::Clip& clip);

private:
  OutputFile& first_;
  bool is_there_ = false;
};

/// How the last frame looks from the side, now and then: PATTERN_0001.png, … Not thread-safe.
class LivePreview {
public:
  static constexpr double kDegrees = 30; ///< to the right of the capture camera

  /// `every`: seconds between two pictures. Throws Error(kUsage) if no format writes such pictures.
  LivePreview(std::filesystem::path pattern, double every, bool overwrite, const host::PluginTable& plugins);
  /// Draws it if it is time. Throws Error(kUnwritableOutput).
  void show(const clip::Clip& clip);

private:
  std::filesystem::path pattern_;
  double every_;
  bool overwrite_;
  const host::PluginTable& plugins_;
  std::size_t count_ = 0;
  std::optional<std::chrono::steady_clock::time_point> last_;
};

} // namespace kinora::cli
