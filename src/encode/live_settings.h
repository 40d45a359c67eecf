// What can be changed about training while a capture goes on.
#pragma once

#include <cstddef>

namespace kinora::encode {

enum class KeyFrameRule {
  kInterval, ///< every n-th; whenever there are too many every other one goes and n doubles
  kPaper,    ///< farther than γ from all others; of too many the one nearest to another goes (paper_distance.h)
  kCoverage  ///< of too many the one goes that shows least that others do not show twice
};

struct KeyFrameConfig {
  KeyFrameRule rule = KeyFrameRule::kCoverage;
  std::size_t capacity = 24;  ///< frames, at least 2
  double min_sharpness = 0.8; ///< of the median of the last frames: a frame below is left out as blurred; 0: none is
  double spread =
      0.1; ///< worth of a long time to the next key frames, half of it for a second; beside new places (kCoverage)
  std::size_t similar = 10; ///< frames that are most like an asked view, and as many of the newest (eq. 7 ff., m)
};

struct LiveTrainingConfig {
  std::size_t first_rays = 24'000;       ///< of all layers together, in the first round: a picture is wanted soon
  std::size_t rays = 200'000;            ///< in every later one
  std::size_t view_rays = 50'000;        ///< in a burst for a view that is asked for
  int rays_per_step = 256;               ///< a round has few rays: many small steps learn more of them
  std::size_t pixels_per_frame = 50'000; ///< that are looked at
  double spare = 0.1;                    ///< of a box's side: room for surface that comes into view
};

struct LiveSettings {
  KeyFrameConfig key_frames;
  LiveTrainingConfig training;
};

} // namespace kinora::encode
