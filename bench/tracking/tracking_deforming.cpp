// Follows a deforming layer of a capture and compares it with the ground truth beside it: material tracks
// (gt/tracks.csv.gz) or scene flow (scene_flow/*.sflow, with the mask of the first frame), and milliseconds per frame.
// Usage: bench_tracking_deforming CAPTURE [LABEL]; with KINORA_BENCH_FRAMES set, also frame by frame; with
// KINORA_BENCH_UNSETTLED set, without DeformingTracker::settle_past; with KINORA_BENCH_NO_BODY set, without a skeleton.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>

#include "core/error.h"
#include "core/image_codec.h"
#include "follow_label.h"
#include "host/plugin_table.h"
#include "ingest/capture.h"
#include "ingest/true_tracks.h"
#include "tracking/deforming_tracker.h"
#include "tracking/point_track.h"

namespace {

using namespace kinora;
using bench::at_fraction;

struct Errors {
  std::vector<double> values; ///< millimetres
  int missing = 0;

  void add(const Eigen::Vector3d& estimated, const Eigen::Vector3d& truth) {
    if (estimated.allFinite()) {
      values.push_back(1e3 * (estimated - truth).norm());
    } else {
      ++missing;
    }
  }
  void print(const char* what) {
    double sum = 0;
    for (const double value : values) sum += value;
    std::printf("%s: mean %.2f mm, median %.2f, 95 %% %.2f, %zu places, %d missing\n", what,
                values.empty() ? 0.0 : sum / static_cast<double>(values.size()), at_fraction(values, 0.5),
                at_fraction(values, 0.95), values.size(), missing);
  }
};

// Each track from its first visible frame, over all frames.
void compare_tracks(const ingest::TrueTracks& tracks, const tracking::Motion& motion, const std::vector<int>& frames) {
  Errors visible;
  Errors hidden;
  std::vector<Errors> by_frame(frames.size());
  std::vector<std::pair<double, int>> worst;
  for (const auto& track_of_id : tracks) {
    const int id = track_of_id.first;
    const std::map<int, ingest::TruePlace>& places = track_of_id.second;
    const auto first = std::find_if(frames.begin(), frames.end(), [&](int frame) {
      const auto found = places.find(frame);
      return found != places.end() && found->second.visible;
    });
    if (first == frames.end()) continue;
    const auto start = static_cast<std::size_t>(first - frames.begin());
    const auto track = tracking::track_point(motion, frames.size(), start, places.at(*first).point);
    double sum = 0;
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const auto truth = places.find(frames[i]);
      if (truth == places.end()) continue;
      (truth->second.visible ? visible : hidden).add(track[i], truth->second.point);
      if (truth->second.visible) by_frame[i].add(track[i], truth->second.point);
      sum += (track[i] - truth->second.point).norm();
    }
    worst.emplace_back(1e3 * sum / static_cast<double>(frames.size()), id);
  }
  visible.print("visible");
  hidden.print("hidden");
  if (std::getenv("KINORA_BENCH_FRAMES") != nullptr) {
    for (std::size_t i = 0; i < frames.size(); ++i) by_frame[i].print(std::to_string(frames[i]).c_str());
    std::sort(worst.rbegin(), worst.rend());
    for (std::size_t i = 0; i < std::min<std::size_t>(25, worst.size()); ++i) {
      const auto& place = tracks.at(worst[i].second).begin()->second.point;
      std::printf("track %d: %.1f mm, at first (%.2f %.2f %.2f)\n", worst[i].second, worst[i].first, place.x(),
                  place.y(), place.z());
    }
  }
}

/// DeepDeform's scene flow of the first frame: x, y, z in planes, −inf where unknown.
struct SceneFlow {
  int width = 0;
  int height = 0;
  std::vector<float> values;
};

SceneFlow read_scene_flow(const std::filesystem::path& folder) {
  SceneFlow flow;
  if (!std::filesystem::is_directory(folder)) return flow;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    std::ifstream file(entry.path(), std::ios::binary);
    std::array<std::int32_t, 3> header{};
    file.read(reinterpret_cast<char*>(header.data()), sizeof header);
    flow.width = header[0];
    flow.height = header[1];
    flow.values.resize(static_cast<std::size_t>(header[0]) * static_cast<std::size_t>(header[1]) * 3);
    file.read(reinterpret_cast<char*>(flow.values.data()),
              static_cast<std::streamsize>(flow.values.size() * sizeof(float)));
  }
  return flow;
}

void compare_flow(const SceneFlow& flow, const ingest::Frame& first, const tracking::Motion& motion) {
  Errors errors;
  Errors still;
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector3d> truths;
  const std::size_t plane = static_cast<std::size_t>(flow.width) * static_cast<std::size_t>(flow.height);
  for (int v = 0; v < flow.height; ++v) {
    for (int u = 0; u < flow.width; ++u) {
      const std::size_t i =
          static_cast<std::size_t>(v) * static_cast<std::size_t>(flow.width) + static_cast<std::size_t>(u);
      const Eigen::Vector3d change(flow.values[i], flow.values[plane + i], flow.values[2 * plane + i]);
      if (!change.allFinite() || first.depth.at(u, v) <= 0) continue;
      points.push_back(first.camera.intrinsics.unproject(u, v, first.depth.at(u, v)));
      truths.push_back(points.back() + change);
    }
  }
  const auto tracks = tracking::track_points(motion, 2, 0, points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    errors.add(tracks[i][1], truths[i]);
    still.add(points[i], truths[i]);
  }
  errors.print("scene flow");
  still.print("no motion");
}

// The mask of DeepDeform's first frame, if there is one beside it.
LabelImage read_first_mask(const std::filesystem::path& folder, const ColorImage& like) {
  LabelImage mask;
  if (!std::filesystem::is_directory(folder)) return mask;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    std::ifstream file(entry.path(), std::ios::binary);
    const std::vector<char> bytes((std::istreambuf_iterator<char>(file)), {});
    mask = decode_labels(std::as_bytes(std::span(bytes)), entry.path().string());
    if (!mask.same_size(like)) mask = {};
  }
  return mask;
}

void run(const std::string& folder, int label) {
  Progress silent;
  const host::PluginTable plugins = host::PluginTable::builtin();
  const SceneFlow flow = read_scene_flow(std::filesystem::path(folder) / "scene_flow");
  ingest::CaptureOptions options;
  options.use_masks = flow.values.empty();
  const auto capture = ingest::Capture::open(plugins, folder, options, silent);
  tracking::DeformingTrackerConfig config;
  config.use_body = std::getenv("KINORA_BENCH_NO_BODY") == nullptr;
  tracking::DeformingTracker tracker(label, config);
  std::vector<double> milliseconds;
  std::vector<int> frames;
  int not_tracked = 0;
  ingest::Frame first;
  while (auto frame = capture->next()) {
    if (frames.empty() && !flow.values.empty()) {
      frame->labels = read_first_mask(std::filesystem::path(folder) / "mask", frame->color);
    }
    const auto start = std::chrono::steady_clock::now();
    const tracking::DeformingTrackingResult result = tracker.track(*frame);
    milliseconds.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    if (result.health != tracking::Health::kTracked) ++not_tracked;
    if (std::getenv("KINORA_BENCH_FRAMES") != nullptr) {
      std::printf("frame %d: %s, %zu nodes, inliers %.3f of %zu, correlation %.3f, %.0f ms\n", frame->index,
                  std::string(tracking::name_of(result.health)).c_str(), result.nodes, result.quality.inlier_share(),
                  result.quality.on_label, result.quality.texture_correlation, milliseconds.back());
    }
    if (frames.empty()) first = *frame;
    frames.push_back(frame->index);
  }
  std::printf("frames %zu, not tracked %d, spacing %.1f mm\n", frames.size(), not_tracked,
              1e3 * tracker.node_spacing());
  std::printf("body: %s, explained %.3f, empty %.3f\n",
              std::string(tracking::name_of(tracker.body().verdict())).c_str(), tracker.body().explained(),
              tracker.body().empty());
  const auto start = std::chrono::steady_clock::now();
  if (std::getenv("KINORA_BENCH_UNSETTLED") == nullptr) tracker.settle_past();
  const double settling = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const tracking::Motion motion = tracker.motion();
  const ingest::TrueTracks tracks = ingest::read_true_tracks(folder);
  if (!tracks.empty()) compare_tracks(tracks, motion, frames);
  if (!flow.values.empty()) compare_flow(flow, first, motion);
  std::printf("nodes %zu; per frame: median %.1f ms, 99th percentile %.1f ms; their past settled in %.2f s\n",
              motion.graph()->nodes().size(), at_fraction(milliseconds, 0.5), at_fraction(milliseconds, 0.99),
              settling);
}

} // namespace

int main(int argc, char** argv) { return kinora::bench::follow_label(argc, argv, 1, run); }
