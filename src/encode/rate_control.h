// How finely each level of each field is stored, so that a file takes the bytes that it may.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "clip/clip.h"
#include "clip/payloads/field_codec.h"
#include "core/progress.h"

namespace kinora::encode {

struct RateChoice {
  std::vector<clip::FieldRounding> fields; ///< of each layer: clip::StorageOptions
  std::size_t bytes = 0;                   ///< that the file will take
  double picture_psnr = 0; ///< estimated: of pictures drawn with them against those of the clip itself, dB, at most
                           ///< 100; within 3 above 32, too many below
};

/// Bits go where they lower the error most: levels are rounded one at a time, the clip is drawn with each (two
/// instants, the capture's camera and one 25 degrees beside it), and of all levels those steps are taken that leave the
/// least error together. What is no level (motion, networks, occupancy) costs what it costs. The same clip gives the
/// same choices. Thread-safe.
class RateControl {
public:
  /// Draws. `usual_bytes`: what the file takes as write_clip stores it unasked. Throws Error(kInterrupted).
  RateControl(const clip::Clip& clip, std::size_t usual_bytes, Progress& progress);
  ~RateControl();

  std::size_t fewest_bytes() const; ///< with the cheapest of everything
  std::size_t most_bytes() const;   ///< beyond which nothing becomes better

  /// The best of at most `bytes`; the cheapest if those are too few.
  RateChoice for_bytes(std::size_t bytes) const;

private:
  struct Units;
  std::unique_ptr<const Units> units_;
};

} // namespace kinora::encode
