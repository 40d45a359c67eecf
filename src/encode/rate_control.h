// How finely each level of each field is stored, so that a file takes the bytes that it may.
#pragma once

#include <cstddef>
#include <vector>

#include "clip/clip.h"
#include "clip/payloads/field_codec.h"
#include "core/progress.h"

namespace kinora::encode {

struct RateChoice {
  std::vector<clip::FieldRounding> fields; ///< of each layer: clip::StorageOptions
  std::size_t bytes = 0;                   ///< that the file will take
  std::size_t fewest_bytes = 0;            ///< with the cheapest of everything
  std::size_t most_bytes = 0;              ///< beyond which nothing becomes better
};

/// Bits go where they lower the error most: levels are rounded one at a time, the clip is drawn with each (two
/// instants, the capture's camera and one 25 degrees beside it), and the steps of all levels are taken in the order of
/// error per byte until the file has `wanted_bytes`. `usual_bytes`: what the file takes as write_clip stores it
/// unasked. What is no level (motion, networks, occupancy) costs what it costs. Where `wanted_bytes` are fewer than
/// `fewest_bytes`, those are chosen. The same clip gives the same choice. Thread-safe. Throws Error(kInterrupted).
RateChoice choose_rounding(const clip::Clip& clip, std::size_t usual_bytes, std::size_t wanted_bytes,
                           Progress& progress);

} // namespace kinora::encode
