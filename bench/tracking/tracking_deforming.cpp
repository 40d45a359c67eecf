// Follows a deforming layer of a capture with each combination of its knobs and compares it with the ground truth
// beside it: material tracks (gt/tracks.csv.gz) or scene flow (scene_flow/*.sflow, with the mask of the first frame).
// A table in CSV: the knobs, milliseconds per frame, and errors in millimetres.
// Usage: bench_tracking_deforming CAPTURE [KNOB=VALUE,VALUE...]; frames=1 also tells it frame by frame.
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "core/image_codec.h"
#include "evaluate/ground_truth_tracks.h"
#include "host/plugin_table.h"
#include "ingest/capture/capture.h"
#include "knobs.h"
#include "motion/point_track.h"
#include "nearby_objects.h"
#include "picture_agreement.h"
#include "stopwatch.h"
#include "track_errors.h"
#include "tracking/deforming/deforming_tracker.h"

namespace {

using namespace kinora;
using bench::at_fraction;
using bench::Comparison;
using bench::Errors;
using bench::Setting;

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

constexpr double kTrueFlowIsCertain = 0.5; // its correlation of what the two pictures show

Comparison compare_flow(const SceneFlow& flow, const std::vector<ingest::Frame>& frames, const motion::Motion& motion) {
  const ingest::Frame& first = frames.front();
  bench::PictureAgreement tracked(first, frames.back());
  bench::PictureAgreement true_flow(first, frames.back());
  std::vector<std::array<int, 2>> pixels;
  Comparison all;
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
      pixels.push_back({u, v});
      points.push_back(first.camera.intrinsics.unproject(u, v, first.depth.at(u, v)));
      truths.push_back(points.back() + change);
    }
  }
  const auto tracks = motion::track_points(motion, 2, 0, points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    all.visible.add(tracks[i][1], truths[i]);
    still.add(points[i], truths[i]);
    tracked.add(pixels[i][0], pixels[i][1], tracks[i][1]);
    true_flow.add(pixels[i][0], pixels[i][1], truths[i]);
  }
  std::printf("# without motion: %s mm; picture repeated: correlation %.3f along the tracks, %.3f along the truth\n",
              still.text().c_str(), tracked.mean(), true_flow.mean());
  Errors certain;
  std::size_t count = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto agreement = true_flow.correlation(pixels[i][0], pixels[i][1]);
    if (!agreement || *agreement < kTrueFlowIsCertain) continue;
    certain.add(tracks[i][1], truths[i]);
    ++count;
  }
  std::printf("# where the truth repeats the picture with a correlation of %.1f at least: %s mm of %zu points of %zu\n",
              kTrueFlowIsCertain, certain.text().c_str(), count, points.size());
  return all;
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

tracking::DeformingTrackerConfig config_of(const Setting& knobs) {
  const auto whole = [&](const char* name) { return static_cast<int>(knobs.at(name)); };
  tracking::DeformingTrackerConfig config;
  config.in_view.max_points = static_cast<std::size_t>(knobs.at("points"));
  config.model.first_nodes = static_cast<std::size_t>(knobs.at("nodes"));
  config.model.voxel_size = knobs.at("voxel");
  config.model.fuse_interval = whole("fuse_interval");
  config.binding.use_body = whole("body") != 0;
  config.use_objects = whole("interaction") != 0;
  config.in_view.solver.iterations = {whole("coarse"), whole("middle"), whole("fine")};
  config.in_view.solver.rigid_iterations = whole("rigid");
  config.in_view.solver.pcg_iterations = whole("pcg");
  config.in_view.solver.min_decrease = knobs.at("worthwhile");
  config.in_view.solver.rigidity = knobs.at("rigidity");
  config.in_view.solver.prior_sigma = knobs.at("prior");
  config.in_view.solver.photometric_weight = knobs.at("texture");
  config.in_view.solver.silhouette_weight = knobs.at("silhouette");
  return config;
}

std::vector<ingest::Frame> read_frames(const std::string& folder, const SceneFlow& flow) {
  Progress silent;
  const host::PluginTable plugins = host::PluginTable::builtin();
  ingest::CaptureOptions options;
  options.use_masks = flow.values.empty();
  const auto capture = ingest::Capture::open(plugins, folder, options, silent);
  std::vector<ingest::Frame> frames;
  while (auto frame = capture->next()) frames.push_back(std::move(*frame));
  if (!frames.empty() && !flow.values.empty()) {
    frames[0].labels = read_first_mask(std::filesystem::path(folder) / "mask", frames[0].color);
  }
  return frames;
}

void follow(const std::string& folder, const std::vector<ingest::Frame>& frames, const SceneFlow& flow,
            const Setting& knobs) {
  tracking::DeformingTracker tracker(static_cast<int>(knobs.at("label")), config_of(knobs));
  const bool each = knobs.at("frames") != 0;
  std::vector<double> milliseconds;
  std::vector<double> processor;
  int not_tracked = 0;
  bench::NearbyObjects objects(static_cast<int>(knobs.at("label")));
  for (const ingest::Frame& frame : frames) {
    const std::vector<tracking::NearbyObject> nearby = objects.follow(frame);
    const bench::Stopwatch watch;
    const tracking::DeformingTrackingResult result = tracker.track(frame, nearby);
    milliseconds.push_back(watch.milliseconds());
    processor.push_back(watch.processor_milliseconds());
    if (result.health != motion::Health::kTracked) ++not_tracked;
    if (!each) continue;
    std::printf("# frame %d: %s, %zu nodes, inliers %.3f of %zu, correlation %.3f, %.0f ms\n", frame.index,
                std::string(motion::name_of(result.health)).c_str(), result.nodes, result.quality.inlier_share(),
                result.quality.on_label, result.quality.texture_correlation, milliseconds.back());
  }
  const motion::Motion unsettled = tracker.motion();
  const bench::Stopwatch watch;
  const tracking::TrackedLayer layer = std::move(tracker).finish().value();
  const double settling = watch.milliseconds();
  const motion::Motion& motion = knobs.at("settle") != 0 ? layer.motion : unsettled;
  std::printf("# %zu frames, %d not tracked; %zu nodes, %.1f mm apart; body: %s, explained %.3f, empty %.3f; past "
              "settled in %.2f s\n",
              frames.size(), not_tracked, motion.graph()->nodes().size(), 1e3 * layer.node_spacing,
              std::string(tracking::name_of(layer.body.verdict())).c_str(), layer.body.explained(),
              layer.body.free_space(), 1e-3 * settling);
  const evaluate::GroundTruthTracks tracks = evaluate::read_ground_truth_tracks(folder);
  Comparison comparison;
  std::vector<int> numbers;
  numbers.reserve(frames.size());
  for (const ingest::Frame& frame : frames) numbers.push_back(frame.index);
  if (!tracks.empty()) comparison = bench::compare_tracks(tracks, motion, numbers, each);
  if (!flow.values.empty()) comparison = compare_flow(flow, frames, motion);
  for (const auto& [name, value] : knobs) std::printf("%g,", value);
  std::printf("%.1f,%.1f,%.1f,%s,%s\n", at_fraction(milliseconds, 0.5), at_fraction(milliseconds, 0.99),
              at_fraction(processor, 0.5), comparison.visible.text().c_str(), comparison.hidden.text().c_str());
  std::fflush(stdout);
}

} // namespace

int main(int argc, char** argv) {
  const tracking::DeformingTrackerConfig defaults;
  const tracking::DeformingAlignmentConfig& alignment = defaults.in_view.solver;
  bench::Knobs knobs{{"label", {1}},
                     {"points", {static_cast<double>(defaults.in_view.max_points)}},
                     {"nodes", {static_cast<double>(defaults.model.first_nodes)}},
                     {"voxel", {defaults.model.voxel_size}},
                     {"fuse_interval", {static_cast<double>(defaults.model.fuse_interval)}},
                     {"coarse", {static_cast<double>(alignment.iterations[0])}},
                     {"worthwhile", {alignment.min_decrease}},
                     {"middle", {static_cast<double>(alignment.iterations[1])}},
                     {"fine", {static_cast<double>(alignment.iterations[2])}},
                     {"rigid", {static_cast<double>(alignment.rigid_iterations)}},
                     {"pcg", {static_cast<double>(alignment.pcg_iterations)}},
                     {"rigidity", {alignment.rigidity}},
                     {"prior", {alignment.prior_sigma}},
                     {"texture", {alignment.photometric_weight}},
                     {"silhouette", {alignment.silhouette_weight}},
                     {"body", {1}},
                     {"interaction", {1}},
                     {"settle", {1}},
                     {"frames", {0}}};
  try {
    bool usable = argc > 1;
    for (int i = 2; i < argc; ++i) usable = usable && bench::set_knob(argv[i], knobs);
    if (!usable) {
      std::fprintf(stderr, "usage: %s CAPTURE [KNOB=VALUE,VALUE...]; the knobs stand at the end of its source\n",
                   argv[0]);
      return 2;
    }
    const SceneFlow flow = read_scene_flow(std::filesystem::path(argv[1]) / "scene_flow");
    const std::vector<ingest::Frame> frames = read_frames(argv[1], flow);
    for (const auto& [name, values] : knobs) std::printf("%s,", name.c_str());
    std::printf("median_ms,99th_percentile_ms,processor_ms,seen_mean_mm,seen_median_mm,seen_95_percent_mm,"
                "hidden_mean_mm,hidden_median_mm,hidden_95_percent_mm\n");
    bench::run_all(knobs, [&](const Setting& setting) { follow(argv[1], frames, flow, setting); });
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
