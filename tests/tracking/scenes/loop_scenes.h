// Long ways of a camera through a room, with what makes it drift: what closing loops is tested and measured on.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "room_scene.h"

namespace kinora::tracking::testing {

struct LoopScene {
  std::string name;
  std::vector<SE3> truth;           ///< camera to world
  std::vector<RoomOptions> options; ///< of each frame

  std::size_t size() const { return truth.size(); }
  ingest::Frame render(std::size_t i) const { return render_room(truth[i], static_cast<int>(i), options[i]); }
};

/// Once around and on to 400°, looking outwards from a circle. Depth is bent as sensors bend it, so that the
/// way seems 10 to 17° longer or shorter than it is. `seed` varies the way, its speed, the drift and the noise.
LoopScene rotate_around(std::uint64_t seed);

/// The same, with a fast stretch, one in the dark, and one before nothing but a bare wall.
LoopScene rotate_with_hard_stretches(std::uint64_t seed);

/// Half around; then something lies on the lens while the camera goes back to a place 60° and 0.4 m away.
LoopScene covered_on_the_way(std::uint64_t seed);

/// Once around and `periods` aside before a wall where everything repeats: it looks as where the camera began, but is
/// another place.
LoopScene alike_place(std::uint64_t seed, double periods);

} // namespace kinora::tracking::testing
