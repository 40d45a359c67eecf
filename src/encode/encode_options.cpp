#include "encode/encode_options.h"

#include <algorithm>

namespace kinora::encode {

EncodeOptions EncodeOptions::of(Preset preset) {
  EncodeOptions options;
  options.preset = preset;
  options.settings.budget = budget_of(preset);
  return options;
}

std::size_t EncodeOptions::expected_frames(int frame_count) const {
  return static_cast<std::size_t>(std::max(1, frames.count_of(frame_count)));
}

nlohmann::json EncodeOptions::json() const {
  return {{"preset", name_of(preset)},
          {"holdout", holdout},
          {"holdout_tracked", holdout_tracked},
          {"body_from", body_from},
          {"frames", {{"begin", frames.begin}, {"end", frames.end.value_or(-1)}, {"step", frames.step}}}};
}

} // namespace kinora::encode
