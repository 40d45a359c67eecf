// Which pixels of a still camera's capture show something that moves.
#pragma once

#include <optional>

#include "ingest/capture/capture.h"

namespace kinora::evaluate {

/// Immutable; thread-safe.
class MovingPixels {
public:
  /// Looks at up to 120 frames, evenly spread. Nothing if the camera moves or there are fewer than 3 frames. Throws
  /// what the capture throws.
  static std::optional<MovingPixels> of(ingest::Capture& capture);

  /// 1 where the colour, in the pixel or one of its eight neighbours, differs from the pixel's median over time by more
  /// than 12 of 255 (mean over the channels); else 0.
  LabelImage in(const ColorImage& color) const;

private:
  ColorImage median_; ///< over time, per channel
};

} // namespace kinora::evaluate
