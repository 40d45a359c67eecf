// Everything that a run of the encoder depends on besides the capture.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "core/frame_range.h"
#include "tracking/body/body_prior.h"

namespace kinora::encode {

enum class Preset { kFast, kBalanced, kBest };

/// "fast", "balanced" or "best"; throws Error(kUsage) for anything else.
Preset parse_preset(const std::string& name);
std::string name_of(Preset preset);

struct EncodeOptions {
  Preset preset = Preset::kBalanced;
  int holdout = 0;       ///< frames N−1, 2N−1, … of those used are tracked but never trained on; 0: none
  std::string body_from; ///< in words, for the record: whose measures `body` holds
  std::optional<tracking::BodyPrior> body; ///< what is known of the measures of everybody in the capture
  FrameRange frames; ///< the range that the capture was opened with: how many frames are to be expected
  std::uint64_t seed = 1;
  std::size_t max_stored_pixels = 24'000'000; ///< bound of what training remembers; 12 bytes each
  /// Rays that train all layers together: rays_per_pixel × pixels of all frames, kept within the bounds.
  double rays_per_pixel = 0;
  std::size_t min_rays = 0;
  std::size_t max_rays = 0;
  bool try_geometries = false; ///< whether each layer takes the geometry that draws it better (geometry_trial.h)

  /// The documented budget of a preset; `balanced` is the default.
  static EncodeOptions of(Preset preset);
  /// Frames within the range of a source of `frame_count` frames; at least 1.
  std::size_t expected_frames(int frame_count) const;
  nlohmann::json json() const;
};

} // namespace kinora::encode
