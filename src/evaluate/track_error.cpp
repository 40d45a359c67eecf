#include "evaluate/track_error.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <vector>

#include "motion/point_track.h"

namespace kinora::evaluate {
namespace {

using Json = nlohmann::json;

constexpr int kPersonLabel = 1;

struct Errors {
  std::vector<double> metres;
  int missing = 0;

  Json json() {
    if (metres.empty()) return {{"places", 0}, {"missing", 0}};
    const auto rounded = [](double value) { return std::round(value * 1e5) / 1e5; };
    const double mean = std::accumulate(metres.begin(), metres.end(), 0.0) / static_cast<double>(metres.size());
    const auto p95 = metres.begin() + static_cast<std::ptrdiff_t>(metres.size() * 95 / 100);
    std::nth_element(metres.begin(), p95, metres.end());
    return {{"places", metres.size()},
            {"error_m_mean", rounded(mean)},
            {"error_m_p95", rounded(*p95)},
            {"missing", missing}};
  }
};

/// A point's true places at the frames of the clip, and the first at which it is seen.
struct Track {
  std::vector<std::optional<TruePosition>> positions; ///< world
  std::size_t start = 0;
};

std::optional<Track> track_in(const clip::Clip& clip, const std::map<int, TruePosition>& truth) {
  Track track;
  std::optional<std::size_t> start;
  for (std::size_t i = 0; i < clip.times.size(); ++i) {
    auto& position = track.positions.emplace_back();
    const auto found = truth.find(clip.capture_frames[i]);
    if (found == truth.end()) continue;
    position = found->second;
    position->point = clip.capture_camera(static_cast<double>(i)).camera_to_world * position->point;
    if (!start && position->visible) start = i;
  }
  if (!start) return std::nullopt;
  track.start = *start;
  return track;
}

} // namespace

Json track_error(const clip::Clip& clip, const GroundTruthTracks& tracks) {
  const auto layer = std::find_if(clip.layers.begin(), clip.layers.end(),
                                  [](const clip::Layer& l) { return l.label == kPersonLabel; });
  if (layer == clip.layers.end() || tracks.empty()) return nullptr;
  std::map<std::size_t, std::vector<Track>> tracks_from; // by the frame that they start at
  for (const auto& [id, truth] : tracks) {
    if (auto track = track_in(clip, truth)) tracks_from[track->start].push_back(std::move(*track));
  }
  Errors visible;
  Errors hidden;
  for (const auto& [start, group] : tracks_from) {
    std::vector<Eigen::Vector3d> given;
    given.reserve(group.size());
    for (const Track& track : group) given.push_back(track.positions[start]->point);
    const auto predicted = motion::track_points(layer->motion, clip.times.size(), start, given);
    for (std::size_t k = 0; k < group.size(); ++k) {
      for (std::size_t i = 0; i < clip.times.size(); ++i) {
        const auto& position = group[k].positions[i];
        if (i == start || !position) continue;
        Errors& errors = position->visible ? visible : hidden;
        errors.metres.push_back((predicted[k][i] - position->point).norm());
        errors.missing += layer->motion.health(i) == motion::Health::kLost ? 1 : 0;
      }
    }
  }
  return {{"layer", layer->name}, {"visible", visible.json()}, {"hidden", hidden.json()}};
}

} // namespace kinora::evaluate
