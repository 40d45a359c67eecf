// A clip that can be read while it grows, and pictures of it.
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>

#include "cli/context.h"
#include "cli/output_file.h"
#include "clip/live_clip_writer.h"
#include "core/error.h"
#include "core/se3.h"

namespace kinora::cli {

/// A live clip under the output's name from the first write on, which others may follow, and in the end a clip in its
/// place. Not thread-safe.
class GrowingClipFile {
public:
  /// `output`: not committed yet.
  explicit GrowingClipFile(OutputFile& output) : output_(output) {}
  /// The clip as it is now; it is on the disk when this returns. Throws Error(kUnwritableOutput): what was written
  /// before stays, and is complete.
  void write(const clip::Clip& clip);
  /// The clip as it stays, as if it had been encoded at once. Throws as above.
  void finish(const clip::Clip& clip);

private:
  [[noreturn]] void tell_what_is_there(const Error& error) const;

  OutputFile& output_;
  std::optional<clip::LiveClipWriter> live_;
};

/// How the last frame looks from the side, now and then: PATTERN_0001.png, … Not thread-safe.
class LivePreview {
public:
  static constexpr double kDegrees = 30; ///< to the right of the capture camera

  /// `every`: seconds between two pictures. Throws Error(kUsage) if no format writes such pictures.
  LivePreview(std::filesystem::path pattern, double every, bool overwrite, const host::PluginTable& plugins);
  /// Draws it if it is time. Throws Error(kUnwritableOutput).
  void show(const clip::Clip& clip);
  /// Where the last picture was seen from, camera to world.
  const std::optional<SE3>& seen_from() const { return seen_from_; }

private:
  std::filesystem::path pattern_;
  double every_;
  bool overwrite_;
  const host::PluginTable& plugins_;
  std::size_t count_ = 0;
  std::optional<SE3> seen_from_;
  std::optional<std::chrono::steady_clock::time_point> last_;
};

} // namespace kinora::cli
