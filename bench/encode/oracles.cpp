// What limits pictures: a synthetic capture encoded with what is known of it in the place of what is measured, one
// thing at a time and all together:
//   bench_oracles CAPTURE [PRESET [SEEDS]]        (default: balanced, 1 seed)
// - masks: the capture's labels, which are exact; without them labels come from what moves;
// - depth: without noise, holes and range (gt/depth_clean);
// - motion: poses of things from gt/object_pose.txt; nodes of people corrected by gt/tracks.csv.gz, and refined through
//   the field as ever;
// - bytes: fields are not rounded.
// Prints means: PSNR of everything that is labelled over its box, in frames of the capture that were tracked and not
// trained on (every tenth), and from the truth's other cameras, there also within the silhouette; seen points' error.
#include <cstdio>
#include <cstdlib>

#include "encode/capture_preparation.h"
#include "encode/layer_presence.h"
#include "encode/layer_training.h"
#include "encode/training_plan.h"
#include "evaluate/ground_truth.h"
#include "host/plugin_table.h"
#include "true_depth_capture.h"
#include "true_motion.h"
#include "truth_measures.h"

namespace {

using namespace kinora;

struct Known {
  const char* name;
  bool masks = false;
  bool depth = false;
  bool motion = false;
  bool bytes = false;
};

constexpr Known kRows[] = {{"nothing"},
                           {"masks", true},
                           {"masks, depth", true, true},
                           {"masks, motion", true, false, true},
                           {"masks, bytes", true, false, false, true},
                           {"masks, depth, motion", true, true, true},
                           {"all", true, true, true, true}};

void give_true_motion(const std::filesystem::path& folder, encode::FramePass& pass) {
  const auto truth = evaluate::GroundTruth::read(folder);
  const evaluate::GroundTruthTracks tracks = evaluate::read_ground_truth_tracks(folder);
  for (auto& [number, label] : pass.labels) {
    if (number == 1 && label.layer)
      label.layer->motion = bench::corrected_by_tracks(pass.clip, tracks, label.layer->motion);
    if (number == 2 && truth) bench::give_true_poses(pass.clip, truth->object_to_camera(), label);
  }
}

clip::Clip encoded(const std::filesystem::path& folder, const Known& known, const encode::EncodeOptions& options,
                   Progress& progress) {
  const host::PluginTable plugins = host::PluginTable::builtin();
  encode::CaptureRequest request;
  request.open = [&](const ingest::CaptureOptions& how, Progress& to) {
    std::unique_ptr<ingest::Capture> capture = ingest::Capture::open(plugins, folder, how, to);
    if (known.depth) capture = std::make_unique<bench::TrueDepthCapture>(std::move(capture), folder);
    return capture;
  };
  request.options.use_masks = known.masks;
  encode::PreparedCapture prepared = encode::prepare_capture(request, progress);
  encode::StageTimes times;
  encode::FramePass pass = encode::pass_over_frames(*prepared.capture, options, times, progress);
  if (known.motion) give_true_motion(folder, pass);
  const encode::TrainingPlan plan = encode::plan_training(pass, options);
  for (const encode::LayerJob& job : plan.layers) {
    clip::Layer layer = encode::train_layer(job, pass.pixels, options, times, progress).layer;
    layer.presence = encode::layer_presence(*job.label, layer.motion, pass.pixels, pass.clip.times.size());
    pass.clip.layers.push_back(std::move(layer));
  }
  return std::move(pass.clip);
}

void run(const char* folder, const char* preset, int seeds) {
  std::printf("| known | held out, box dB | other cameras, box dB | inside dB | points mm |\n");
  std::printf("| --- | --- | --- | --- | --- |\n");
  for (const Known& known : kRows) {
    bench::TruthMeasures measures;
    for (int seed = 1; seed <= seeds; ++seed) {
      encode::EncodeOptions options = encode::EncodeOptions::of(encode::parse_preset(preset));
      options.holdout_tracked = 10;
      options.settings.fields.trainer.seed = static_cast<std::uint64_t>(seed);
      if (known.bytes) options.settings.fields.trainer.quantisation = {};
      Progress progress;
      measures.add(folder, encoded(folder, known, options, progress), progress);
    }
    measures.print(known.name);
  }
}

} // namespace

int main(int argc, char** argv) {
  if (argc < 2 || argc > 4) {
    std::fprintf(stderr, "usage: bench_oracles CAPTURE [PRESET [SEEDS]]\n");
    return 2;
  }
  try {
    run(argv[1], argc > 2 ? argv[2] : "balanced", argc > 3 ? std::atoi(argv[3]) : 1);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_oracles: %s\n", error.what());
    return 1;
  }
  return 0;
}
