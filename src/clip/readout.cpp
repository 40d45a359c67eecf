#include "clip/readout.h"

#include <cmath>

#include "core/rolling_shutter.h"

namespace kinora::clip {
namespace {

constexpr double kLongest = 1; // seconds: no camera takes longer

double seconds_of(const nlohmann::json& shutter, const char* name) {
  const auto seconds = shutter.find(name);
  if (seconds == shutter.end() || !seconds->is_number()) return 0;
  const auto value = seconds->get<double>();
  return std::abs(value) <= kLongest ? value : 0;
}

} // namespace

void store_readout(const Readout& readout, nlohmann::json& metadata) {
  if (readout.color == 0) return;
  const auto rounded = [](double seconds) { return std::round(1e5 * seconds) / 1e5; };
  metadata["rolling_shutter"] = {{"readout_s", rounded(readout.color)}, {"depth_readout_s", rounded(readout.depth)}};
}

Readout stored_readout(const nlohmann::json& metadata) {
  const auto shutter = metadata.find("rolling_shutter");
  if (shutter == metadata.end() || !shutter->is_object()) return {};
  return {seconds_of(*shutter, "readout_s"), seconds_of(*shutter, "depth_readout_s")};
}

std::vector<ReadoutMotion> readout_of_frames(const Clip& clip) {
  const Readout readout = stored_readout(clip.metadata);
  if (readout.color == 0 || clip.camera_to_world.size() < 2) return {};
  std::vector<ReadoutMotion> motion;
  for (const Twist& velocity : readout_motion(clip.camera_to_world, clip.times, 1)) {
    motion.push_back({readout.color * velocity, readout.depth * velocity});
  }
  return motion;
}

} // namespace kinora::clip
