// Everything that a run of the encoder depends on besides the capture.
#pragma once

#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "core/frame_range.h"
#include "encode/presets.h"
#include "tracking/body/body_prior.h"

namespace kinora::encode {

struct EncodeOptions {
  Preset preset = Preset::kBalanced;
  /// Frames N−1, 2N−1, … of the range are seen by nothing (HeldOutFrames); their poses are found afterwards; 0: none.
  int holdout = 0;
  int holdout_tracked = 0; ///< frames N−1, 2N−1, … of those used are tracked but never trained on; 0: none
  std::string body_from;   ///< in words, for the record: whose measures `body` holds
  std::optional<tracking::BodyPrior> body; ///< what is known of the measures of everybody in the capture
  FrameRange frames; ///< the range that the capture was opened with: how many frames are to be expected
  Settings settings;

  /// The documented budget of a preset; `balanced` is the default.
  static EncodeOptions of(Preset preset);
  /// Frames within the range of a source of `frame_count` frames; at least 1.
  std::size_t expected_frames(int frame_count) const;
  nlohmann::json json() const;
};

} // namespace kinora::encode
