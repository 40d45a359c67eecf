#include "clip/exposure.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace kinora::clip {
namespace {

using Json = nlohmann::json;

constexpr std::array<const char*, 3> kNames = {"red", "green", "blue"};
constexpr float kMost = 1000; // by which any exposure differs

bool is_gain(const Json& value) {
  if (!value.is_number()) return false;
  const auto gain = value.get<float>();
  return gain > 1 / kMost && gain < kMost;
}

} // namespace

void store_exposure(const Exposure& exposure, Json& metadata) {
  if (exposure.empty()) return;
  Json stored = {{"frames", Json::array()}, {"red", Json::array()}, {"green", Json::array()}, {"blue", Json::array()}};
  for (const auto& [frame, gain] : exposure) {
    stored["frames"].push_back(frame);
    for (std::size_t c = 0; c < 3; ++c) stored[kNames[c]].push_back(std::round(1e3 * gain.factors[c]) / 1e3);
  }
  metadata["exposure"] = std::move(stored);
}

Exposure stored_exposure(const Json& metadata) {
  const auto stored = metadata.find("exposure");
  if (stored == metadata.end() || !stored->is_object()) return {};
  const Json& frames = stored->value("frames", Json::array());
  if (!frames.is_array()) return {};
  Exposure exposure;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    ColorGain gain;
    for (std::size_t c = 0; c < 3; ++c) {
      const auto values = stored->find(kNames[c]);
      if (values == stored->end() || !values->is_array() || values->size() != frames.size()) return {};
      if (!is_gain((*values)[i])) return {};
      gain.factors[c] = (*values)[i].get<float>();
    }
    if (!frames[i].is_number_integer()) return {};
    exposure[frames[i].get<int>()] = gain;
  }
  return exposure;
}

ColorGain gain_at(const Exposure& exposure, int capture_frame) {
  if (exposure.empty()) return {};
  const auto after = exposure.lower_bound(capture_frame);
  if (after == exposure.end()) return exposure.rbegin()->second;
  if (after->first == capture_frame || after == exposure.begin()) return after->second;
  const auto before = std::prev(after);
  const float share =
      static_cast<float>(capture_frame - before->first) / static_cast<float>(after->first - before->first);
  ColorGain gain;
  for (std::size_t c = 0; c < 3; ++c) {
    gain.factors[c] = std::pow(before->second.factors[c], 1 - share) * std::pow(after->second.factors[c], share);
  }
  return gain;
}

} // namespace kinora::clip
