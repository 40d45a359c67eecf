// Pictures as PNG files: a folder of them, or a single one.
#pragma once

#include "common/facts.h"
#include "common/picture_files.h"
#include "kinora/plugin.h"

namespace kinora::formats {

/// Colour goes to <name>.png (8 bits, 3 channels or 4 with straight alpha), depth to <name>.depth.png (16 bits,
/// millimetres). A single picture goes to the path itself, its depth beside it: a.png and a.depth.png, or a.png.part
/// and a.depth.png.part. What describe() is given stands in each as text. Every file is complete once `write` returns.
class PngWriter {
public:
  explicit PngWriter(PictureFiles files) : files_(std::move(files)) {}

  /// Texts of every picture (iTXt), with what its numbers mean.
  void describe(Facts facts) { facts_ = std::move(facts); }
  /// Throws Error: kUnwritableOutput; kUsage for a second picture in a file or a name that leaves the folder.
  void write(const KinoraPicture& picture);
  /// Throws Error(kFailure) if a file was promised and no picture came.
  void finish() const { files_.finish(); }

private:
  Facts texts(const char* content) const;

  PictureFiles files_;
  Facts facts_;
};

} // namespace kinora::formats
