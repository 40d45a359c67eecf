#include "clip/readout.h"

#include <cmath>

#include "core/rolling_shutter.h"

namespace kinora::clip {
namespace {

constexpr double kLongest = 1; // seconds: no camera takes longer

} // namespace

void store_readout(double seconds, nlohmann::json& metadata) {
  if (seconds != 0) metadata["rolling_shutter"] = {{"readout_s", std::round(1e5 * seconds) / 1e5}};
}

double stored_readout(const nlohmann::json& metadata) {
  const auto shutter = metadata.find("rolling_shutter");
  if (shutter == metadata.end() || !shutter->is_object()) return 0;
  const auto seconds = shutter->find("readout_s");
  if (seconds == shutter->end() || !seconds->is_number()) return 0;
  const auto value = seconds->get<double>();
  return std::abs(value) <= kLongest ? value : 0;
}

std::vector<Twist> readout_of_frames(const Clip& clip) {
  const double seconds = stored_readout(clip.metadata);
  if (seconds == 0 || clip.camera_to_world.size() < 2) return {};
  return readout_motion(clip.camera_to_world, clip.times, seconds);
}

} // namespace kinora::clip
