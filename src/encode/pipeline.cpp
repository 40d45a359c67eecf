#include "encode/pipeline.h"

#include "clip/readout.h"
#include "core/error.h"
#include "encode/camera_refinement.h"
#include "encode/capture_report.h"
#include "encode/exposure_gains.h"
#include "encode/frame_pass.h"
#include "encode/held_out_poses.h"
#include "encode/layer_presence.h"
#include "encode/layer_report.h"
#include "encode/layer_training.h"
#include "encode/node_births.h"
#include "encode/still_room.h"
#include "encode/training_plan.h"
#include "encode/unfounded_labels.h"

namespace kinora::encode {
namespace {

using Json = nlohmann::json;

/// What was asked for, and from where labels and joints come.
Json config_json(const PreparedCapture& prepared, const EncodeOptions& options) {
  Json config = options.json();
  config["labels_from"] = prepared.labels_from;
  config["joints_from"] = prepared.joints_from;
  return config;
}

// What was held out joins when nothing can be learnt of it any more.
void add_held_out(PreparedCapture& prepared, const std::optional<CameraRefinement>& refinement, StageTimes& times,
                  clip::Clip& clip, Progress& progress) {
  const bool frames_know_camera = prepared.capture->info().has_poses && !prepared.camera->moves();
  std::optional<std::vector<SE3>> corrections;
  if (frames_know_camera) corrections = refinement ? refinement->corrections : std::vector<SE3>();
  progress.stage("placing held-out frames", 0);
  times.measure("place held-out frames", [&] { add_held_out_frames(clip, *prepared.held_out, corrections, progress); });
}

/// As the camera's motion tells it, or what moves before it.
std::optional<double> depth_delay_of(const PreparedCapture& prepared, const FramePass& pass) {
  return prepared.camera->depth_lag != 0 ? prepared.camera->depth_lag : pass.depth_delay;
}

/// A body knows where all of its parts are.
motion::NodeBirths births_of(const TrackedLabel& label, const clip::Layer& layer, const fields::PixelStore& pixels) {
  constexpr double kReach = 3; // of the distance between nodes: so far those that are seen hold others
  if (layer.motion.kind() != motion::MotionKind::kDeforming || layer.joints) return {};
  return node_births({pixels, layer.label, layer.motion}, kReach * label.layer->node_spacing);
}

} // namespace

EncodeResult encode_capture(PreparedCapture prepared, const EncodeOptions& options, Progress& progress) {
  StageTimes times = std::move(prepared.times);
  FramePass pass = pass_over_frames(*prepared.capture, options, times, progress);
  progress.stage("comparing exposures", 0);
  const clip::Exposure exposure = times.measure("compare exposures", [&] { return measure_exposure(pass); });
  take_out(exposure, pass);
  const std::vector<NotModelled> unfounded = drop_unfounded_labels(pass, prepared.capture->info());
  correct_still_room(pass.pixels);
  TrainingPlan plan = plan_training(pass, options);
  plan.not_modelled.insert(plan.not_modelled.begin(), unfounded.begin(), unfounded.end());
  if (plan.layers.empty()) {
    throw Error(ErrorCode::kFailure,
                "nothing in this capture can be modelled: no still or rigid layer has a pixel with "
                "measured depth");
  }
  const std::optional<CameraRefinement> refinement = refine_camera(pass, plan, options, times, progress);
  const Json config = config_json(prepared, options);
  const Json settings = settings_json(options.settings);
  const Json not_modelled = not_modelled_json(plan.not_modelled);
  clip::Clip& clip = pass.clip;
  clip.metadata.update(clip_metadata(prepared.capture->info(), config, settings));
  clip.metadata["not_modelled"] = not_modelled;
  clip::store_exposure(exposure, clip.metadata);
  if (refinement) clip::store_readout(refinement->readout, clip.metadata);
  Json layers = Json::array();
  for (const LayerJob& job : plan.layers) {
    const FieldDraft* draft = refinement && job.label->plan.label == 0 ? &refinement->draft : nullptr;
    LayerOutcome outcome = train_layer(job, pass.pixels, options, times, progress, draft);
    outcome.layer.presence = layer_presence(*job.label, outcome.layer.motion, pass.pixels, clip.times.size());
    outcome.layer.births = births_of(*job.label, outcome.layer, pass.pixels);
    layers.push_back(layer_json(*job.label, outcome));
    clip.metadata["layers"][outcome.layer.name] = layer_metadata(outcome);
    clip.layers.push_back(std::move(outcome.layer));
  }
  if (prepared.held_out) add_held_out(prepared, refinement, times, clip, progress);
  Json camera = camera_json(prepared);
  if (refinement) camera["refinement"] = refinement_json(*refinement);
  Json report = {{"schema", "kinora.encode/1"},
                 {"version", KINORA_VERSION},
                 {"config", config},
                 {"settings", settings},
                 {"capture", capture_json(prepared, pass)},
                 {"camera", std::move(camera)},
                 {"streams", streams_json(exposure, depth_delay_of(prepared, pass), prepared.registration)},
                 {"layers", std::move(layers)},
                 {"not_modelled", not_modelled},
                 {"timing", {{"stages", times.json(clip.times.size())}}}};
  return {std::move(clip), std::move(report)};
}

} // namespace kinora::encode
