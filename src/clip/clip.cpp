#include "clip/clip.h"

#include <algorithm>
#include <cmath>

namespace kinora::clip {

Camera Clip::capture_camera(double frame) const {
  const double last = static_cast<double>(camera_to_world.size() - 1);
  const double clamped = frame > 0 ? std::min(frame, last) : 0; // NaN goes to the first frame
  const auto i = static_cast<std::size_t>(std::floor(clamped));
  const double fraction = clamped - static_cast<double>(i);
  if (fraction == 0) return {intrinsics, camera_to_world[i]};
  return {intrinsics, interpolate(camera_to_world[i], camera_to_world[i + 1], fraction)};
}

double Clip::frame_at(double seconds) const {
  const auto after = std::upper_bound(times.begin(), times.end(), seconds);
  if (after == times.begin()) return 0;
  const auto i = static_cast<std::size_t>(after - times.begin()) - 1;
  if (after == times.end()) return static_cast<double>(i);
  return static_cast<double>(i) + (seconds - times[i]) / (times[i + 1] - times[i]);
}

} // namespace kinora::clip
