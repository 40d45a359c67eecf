// A film of pictures, through FFmpeg's libraries.
#pragma once

#include <filesystem>
#include <memory>

#include "common/facts.h"
#include "kinora/plugin.h"

namespace kinora::formats {

struct Mp4Settings {
  double frames_per_second = 30; ///< nominal: how long the last picture stays
  int crf = 18;                  ///< 0 (largest file) – 51 (smallest)
  double jump_seconds = 0;       ///< between pictures that need no other; 0: as the encoder likes
};

/// MP4, or WebM where the file is called NAME.webm (also with .part behind it). YUV 4:2:0, BT.709, one thread, nothing
/// of date or machine: the same pictures give the same bytes. An odd size is made even by repeating the last row or
/// column. The film starts with the first picture, whatever its time.
class Mp4Writer {
public:
  /// Throws Error: kUsage for settings out of range, kMissingComponent without an encoder, kUnwritableOutput.
  Mp4Writer(const std::filesystem::path& path, const Mp4Settings& settings);
  ~Mp4Writer();
  Mp4Writer(const Mp4Writer&) = delete;
  Mp4Writer& operator=(const Mp4Writer&) = delete;

  /// The film's comment. Before the first picture.
  void describe(const Facts& facts);
  /// Throws Error: kUsage if the size changes or time does not increase, kUnwritableOutput.
  void write(const KinoraPicture& picture);
  /// Throws Error: kUnwritableOutput, also when the disk is full; kFailure if no picture came.
  void finish();

private:
  class Film;
  std::unique_ptr<Film> film_;
};

} // namespace kinora::formats
