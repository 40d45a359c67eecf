#include "encode/pipeline.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "core/error.h"
#include "encode/layer_report.h"
#include "encode/motion_refinement.h"
#include "encode/scene_tracker.h"
#include "encode/size_report.h"
#include "encode/stage_times.h"
#include "fields/confidence_of_views.h"
#include "fields/geometry_trial.h"
#include "fields/pixel_store.h"
#include "fields/trainer.h"
#include "fields/view_agreement.h"
#include "ingest/depth_unit.h"
#include "ingest/exposure.h"
#include "ingest/registration_json.h"

namespace kinora::encode {
namespace {

using Json = nlohmann::json;

/// What one pass over the frames leaves behind.
struct Pass {
  fields::PixelStore pixels;
  SceneTracker scene;
  ingest::StreamEstimates streams;
  Clip clip;                  ///< timeline and camera path
  std::size_t unlabelled = 0; ///< frames without mask in a capture with masks: tracked nowhere, trained on nowhere
  StageTimes times;
};

bool is_held_out(std::size_t frame, int holdout) {
  return holdout > 0 && (frame + 1) % static_cast<std::size_t>(holdout) == 0;
}

void add_to_timeline(const ingest::Frame& frame, bool held_out, Clip& clip) {
  const double start = clip.capture_frames.empty() ? frame.time : clip.metadata["start_seconds"].get<double>();
  clip.metadata["start_seconds"] = start;
  clip.times.push_back(frame.time - start);
  clip.capture_frames.push_back(frame.index);
  clip.held_out.push_back(held_out);
}

void warn_of_unit(const ingest::Frame& frame, Progress& progress) {
  if (const std::string doubt = ingest::doubt_about_unit(frame.depth); !doubt.empty()) progress.warn(doubt);
}

void pass_over_frames(ingest::Capture& capture, const EncodeOptions& options, Pass& pass, Progress& progress) {
  const ingest::CaptureInfo& info = capture.info();
  progress.stage("reading and tracking", options.expected_frames(info.frame_count));
  for (std::size_t i = 0;; ++i) {
    progress.check();
    auto frame = pass.times.measure("read", [&] { return capture.next(); });
    if (!frame) break;
    if (i == 0) warn_of_unit(*frame, progress);
    const bool held_out = is_held_out(i, options.holdout);
    add_to_timeline(*frame, held_out, pass.clip);
    if (i == 0 || info.has_poses) pass.clip.camera_to_world.push_back(frame->camera.camera_to_world);
    const bool labelled = !info.has_masks || !frame->labels.empty();
    pass.streams.add(*frame);
    pass.scene.add(*frame, pass.times);
    if (!labelled) {
      ++pass.unlabelled;
      progress.warn(fmt::format("frame {} has no mask, unlike others; it is not trained on", frame->index));
    } else if (!held_out) {
      pass.times.measure("store pixels", [&] { pass.pixels.add(*frame, static_cast<int>(i)); });
    }
    progress.advance(i + 1, "");
  }
  pass.scene.finish(pass.times);
  pass.clip.intrinsics = info.intrinsics;
  if (pass.clip.times.empty()) {
    throw Error(ErrorCode::kCorruptInput, "the capture has no usable frame in the range; look at the warnings above");
  }
}

/// Pixels with reliable depth of each label, in frames where the label's place is known.
std::map<int, std::size_t> stored_by_label(const Pass& pass) {
  std::map<int, std::size_t> counts;
  for (const fields::StoredFrame& frame : pass.pixels.frames()) {
    std::array<std::size_t, 256> in_frame{};
    for (std::size_t i = frame.begin; i < frame.end; ++i) {
      const fields::StoredPixel& pixel = pass.pixels.pixels()[i];
      if (pixel.depth > 0) ++in_frame[pixel.label];
    }
    for (const auto& [number, label] : pass.scene.labels()) {
      const auto f = static_cast<std::size_t>(frame.frame);
      const bool lost = f < label.poses.size() && label.poses[f].health == tracking::Health::kLost;
      if (!lost && in_frame[static_cast<std::size_t>(number)] > 0) {
        counts[number] += in_frame[static_cast<std::size_t>(number)];
      }
    }
  }
  return counts;
}

struct LayerJob {
  const TrackedLabel* label;
  std::size_t rays;
};

// Empty if the label can be modelled.
std::string why_not_modelled(const TrackedLabel& label) {
  const auto lost = [](const auto& pose) { return pose.health == tracking::Health::kLost; };
  if (label.tracker && std::all_of(label.poses.begin(), label.poses.end(), lost)) {
    return "too little of it is measured in every frame to follow it";
  }
  if (label.bending && !label.bending->started()) return "too little of it is measured in every frame to follow it";
  return "";
}

// A layer's share of the rays grows with the square root of its pixels: small layers are looked at more closely.
std::vector<LayerJob> share_rays(const Pass& pass, const EncodeOptions& options, Json& not_modelled) {
  const auto counts = stored_by_label(pass);
  std::vector<LayerJob> jobs;
  double weights = 0;
  for (const auto& [number, label] : pass.scene.labels()) {
    const auto found = counts.find(number);
    const std::string why = found == counts.end() ? "it is in no frame that is trained on" : why_not_modelled(label);
    if (!why.empty()) {
      not_modelled.push_back({{"name", label.plan.name}, {"label", number}, {"why", why}});
      continue;
    }
    jobs.push_back({&label, found->second});
    weights += std::sqrt(static_cast<double>(found->second));
  }
  const Intrinsics& camera = pass.clip.intrinsics;
  const double pixels = static_cast<double>(camera.width) * camera.height * static_cast<double>(pass.clip.times.size());
  const TrainingBudget& given = options.settings.budget;
  const auto budget = std::clamp(static_cast<std::size_t>(given.rays_per_pixel * pixels), given.min_rays,
                                 std::max(given.min_rays, given.max_rays));
  for (LayerJob& job : jobs) {
    const double share = std::sqrt(static_cast<double>(job.rays)) / weights;
    job.rays = static_cast<std::size_t>(share * static_cast<double>(budget));
  }
  return jobs;
}

std::string reason_of(const TrackedLabel& label, const tracking::Motion& motion) {
  if (label.plan.motion == tracking::MotionKind::kRigid && motion.kind() == tracking::MotionKind::kStill) {
    return fmt::format("label {} is followed as a rigid object but never moves: no motion is stored", label.plan.label);
  }
  if (!label.bend) return label.plan.why;
  return fmt::format("{}; it bends, from frame {} on by up to {:.1f} cm, and {}", label.plan.why,
                     label.bend->first_frame, 100 * label.bend->metres,
                     label.plan.is_told ? "is kept rigid all the same"
                                        : "so the bending of a graph is tracked instead");
}

// Two labels may have been given one name.
std::string unique_name(const std::string& wanted, const Clip& clip) {
  std::string name = wanted;
  const auto taken = [&] {
    return std::any_of(clip.layers.begin(), clip.layers.end(), [&](const Layer& l) { return l.name == name; });
  };
  for (int i = 2; taken(); ++i) name = fmt::format("{}{}", wanted, i);
  return name;
}

/// A short training with the tracker's motion, and that motion aligned through what was learnt.
struct RefinedLayer {
  std::size_t draft_rays = 0;
  fields::Field draft;
  MotionRefinement refinement;
};

RefinedLayer refine_layer(const TrackedLabel& tracked, const fields::FieldConfig& config,
                          const fields::TrainerConfig& trainer, const EncodeOptions& options, Pass& pass, Layer& layer,
                          Progress& progress) {
  constexpr double kDraftRays = 0.3; // of the layer's (docs/fields.md)
  RefinedLayer refined;
  refined.draft_rays = static_cast<std::size_t>(kDraftRays * static_cast<double>(trainer.rays));
  fields::TrainerConfig shorter = trainer;
  shorter.rays = refined.draft_rays;
  shorter.largest_log2_table_size = 0;
  progress.stage("training a draft of " + layer.name, shorter.rays);
  refined.draft = pass.times.measure("train a draft of " + layer.name, [&] {
    return fields::train_field(pass.pixels, tracked.plan.label, layer.motion, config, shorter, progress);
  });
  progress.stage("refining the motion of " + layer.name, pass.pixels.frames().size());
  layer.motion = pass.times.measure("refine the motion of " + layer.name, [&] {
    return refine_motion(refined.draft, pass.pixels, tracked.plan.label, layer.motion, tracked.bending->edges(),
                         tracked.bending->node_spacing(), progress, &refined.refinement,
                         options.settings.fields.refinement);
  });
  return refined;
}

Json reasons_json(const std::vector<fields::Collapse>& restarts) {
  Json reasons = Json::array();
  for (const fields::Collapse collapse : restarts) reasons.push_back(name_of(collapse));
  return reasons;
}

void train_layer(const LayerJob& job, const EncodeOptions& options, Pass& pass, Json& report, Progress& progress) {
  const TrackedLabel& tracked = *job.label;
  const int label = tracked.plan.label;
  Layer layer{unique_name(tracked.plan.name, pass.clip), label, {}, pass.scene.motion_of(tracked)};
  fields::FieldNeed need;
  fields::FieldConfig config = fields::choose_field_config(pass.pixels, label, layer.motion, &need);
  fields::TrainerConfig trainer = options.settings.fields.trainer;
  if (trainer.rays == 0) trainer.rays = job.rays;
  fields::ViewAgreement agreement;
  const auto compare_views = [&] {
    agreement = fields::agreement_of_views(pass.pixels, label, layer.motion);
    fields::adapt_to(agreement, options.settings.fields.trainer, trainer);
  };
  compare_views();
  fields::GeometryTrial trial;
  if (options.settings.budget.try_geometries) {
    progress.stage("trying geometries of " + layer.name, 0);
    trial = pass.times.measure("try geometries of " + layer.name, [&] {
      return fields::try_geometries(pass.pixels, label, layer.motion, config, trainer, progress);
    });
  }
  config.geometry = trial.chosen;
  std::optional<RefinedLayer> refined;
  if (layer.motion.kind() == tracking::MotionKind::kDeforming) {
    refined = refine_layer(tracked, config, trainer, options, pass, layer, progress);
    compare_views();
    // The training begins with the draft, of which nearly all is right.
    constexpr float kRate = 0.3F;
    trainer.rays -= refined->draft_rays;
    trainer.learning_rates.table *= kRate;
    trainer.learning_rates.nets *= kRate;
  }
  fields::TrainingReport training;
  progress.stage("training " + layer.name, trainer.rays);
  layer.field = pass.times.measure("train " + layer.name, [&] {
    return fields::train_field(pass.pixels, label, layer.motion, config, trainer, progress, &training,
                               refined ? &refined->draft : nullptr);
  });
  layer.confidence = pass.times.measure("confidence of " + layer.name, [&] {
    return fields::confidence_of_views(pass.pixels, label, layer.motion, layer.field);
  });
  layer.joints = pass.scene.joints_of(tracked);
  const std::string why = reason_of(tracked, layer.motion);
  pass.clip.metadata["layers"][layer.name] = {
      {"label", label}, {"why", why}, {"field", config_json(layer.field.config)}, {"trainer", settings_json(trainer)}};
  report["layers"].push_back({{"name", layer.name},
                              {"label", label},
                              {"why", why},
                              {"pixels_seen", tracked.pixels},
                              {"views",
                               {{"looks", agreement.looks},
                                {"seen_through", round4(agreement.seen_through)},
                                {"noise", round4(agreement.noise)}}},
                              {"parameters", layer.field.parameter_count()},
                              {"occupied_cells", layer.field.occupancy.count()},
                              {"motion", motion_json(tracked, layer.motion)},
                              {"field", config_json(layer.field.config)},
                              {"size", size_json(need, config, layer.field, training)},
                              {"geometry", geometry_json(trial)},
                              {"training",
                               {{"rays", training.rays},
                                {"samples", training.samples},
                                {"steps", training.steps},
                                {"bytes", training.bytes},
                                {"final_loss", training.final_loss},
                                {"restarts", training.restarts.size()},
                                {"restarted_because", reasons_json(training.restarts)},
                                {"stray_cells", training.stray_cells}}}});
  if (layer.motion.kind() == tracking::MotionKind::kDeforming) {
    report["layers"].back()["refinement"] = refinement_json(refined->refinement, refined->draft_rays);
  }
  pass.clip.layers.push_back(std::move(layer));
}

Json camera_json(const PreparedCapture& prepared) {
  if (!prepared.camera->report.is_null()) return prepared.camera->report;
  if (!prepared.capture->info().has_poses) return {{"path", "still"}, {"why", "nobody looked whether it moves"}};
  return {{"path", "moving"}, {"why", "the capture brings one camera pose per frame"}};
}

Json capture_json(const PreparedCapture& prepared, const Pass& pass) {
  const ingest::Capture& capture = *prepared.capture;
  const ingest::CaptureInfo& info = capture.info();
  Json skipped = Json::array();
  for (const ingest::SkippedFrame& frame : capture.skipped()) {
    skipped.push_back({{"frame", frame.index}, {"reason", frame.reason}});
  }
  const auto held_out = std::count(pass.clip.held_out.begin(), pass.clip.held_out.end(), true);
  return {{"format", info.format},
          {"size", {info.intrinsics.width, info.intrinsics.height}},
          {"frames_in_source", info.frame_count},
          {"frames_used", pass.clip.times.size()},
          {"frames_held_out", held_out},
          {"frames_without_mask", pass.unlabelled},
          {"frames_per_second", info.frames_per_second},
          {"has_poses", info.has_poses && !prepared.camera->moves()},
          {"has_masks", info.has_masks},
          {"stored_pixels", pass.pixels.pixels().size()},
          {"skipped", skipped}};
}

Json registration_json(const ingest::FoundRegistration& found) {
  if (found.pairs == 0) return {{"applied", false}, {"why", "needs a camera that moves, and views that show the same"}};
  return {{"applied", found.geometry.has_value()},
          {"pairs", found.pairs},
          {"unexplained_as_given", round4(found.unexplained_as_given)},
          {"unexplained", round4(found.unexplained)},
          {"cameras", found.geometry ? ingest::to_json(*found.geometry) : Json(nullptr)}};
}

Json streams_json(const ingest::StreamEstimates& estimates, const ingest::FoundRegistration& registration) {
  const ingest::StreamReport report = estimates.report();
  Json gains = Json::array();
  for (const double gain : report.gains) gains.push_back(round4(gain));
  return {{"exposure_gains", std::move(gains)},
          {"exposure_changes", report.exposure_changes},
          {"depth_behind_color_s", report.time_offset ? Json(round4(*report.time_offset)) : Json(nullptr)},
          {"registration", registration_json(registration)}};
}

} // namespace

EncodeResult encode_capture(const PreparedCapture& prepared, const EncodeOptions& options, Progress& progress) {
  const ingest::CaptureInfo& info = prepared.capture->info();
  TrackingSettings tracking = options.settings.tracking;
  if (options.body) tracking.deforming.body.tracker.known = *options.body;
  Pass pass{fields::PixelStore(options.settings.budget.max_stored_pixels, options.expected_frames(info.frame_count)),
            SceneTracker(info, tracking, progress),
            {},
            {},
            0,
            prepared.times};
  pass_over_frames(*prepared.capture, options, pass, progress);
  Json report = {{"schema", "kinora.encode/1"}, {"layers", Json::array()}, {"not_modelled", Json::array()}};
  const std::vector<LayerJob> jobs = share_rays(pass, options, report["not_modelled"]);
  if (jobs.empty()) {
    throw Error(ErrorCode::kFailure,
                "nothing in this capture can be modelled: no still or rigid layer has a pixel with "
                "measured depth");
  }
  pass.clip.metadata["not_modelled"] = report["not_modelled"];
  for (const LayerJob& job : jobs) train_layer(job, options, pass, report, progress);
  const std::size_t frames = pass.clip.times.size();
  Json config = options.json();
  config["labels_from"] = prepared.labels_from;
  config["joints_from"] = prepared.joints_from;
  pass.clip.metadata["encoder"] = {
      {"version", KINORA_VERSION}, {"options", config}, {"settings", settings_json(options.settings)}};
  pass.clip.metadata["frames_per_second"] = info.frames_per_second;
  if (info.registration) pass.clip.metadata["registration"] = ingest::to_json(*info.registration);
  report["version"] = KINORA_VERSION;
  report["config"] = std::move(config);
  report["settings"] = pass.clip.metadata["encoder"]["settings"];
  report["capture"] = capture_json(prepared, pass);
  report["camera"] = camera_json(prepared);
  report["streams"] = streams_json(pass.streams, prepared.registration);
  report["timing"] = {{"stages", pass.times.json(frames)}};
  return {std::move(pass.clip), std::move(report)};
}

} // namespace kinora::encode
