#include "encode/layer_training.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "encode/motion_smoothing.h"
#include "fields/training/view_confidence.h"

namespace kinora::encode {
namespace {

/// What a draft leaves behind.
struct RefinedDraft {
  FieldDraft draft;
  motion::Motion motion; ///< the layer's, refined and smoothed
  MotionRefinement refinement;
};

/// With what was chosen for the layer so far.
RefinedDraft draft_of(const LayerOutcome& outcome, const fields::LayerObservations& observations,
                      const TrackedLabel& tracked, const MotionRefinementConfig& refinement, StageTimes& times,
                      Progress& progress) {
  const std::string& name = outcome.layer.name;
  progress.stage("training a draft of " + name, 0);
  fields::TrainingReport training;
  fields::Field field = times.measure("train a draft of " + name, [&] {
    return fields::train_field(observations, outcome.config, draft_trainer(outcome.trainer), progress, &training);
  });
  progress.stage("refining the motion of " + name, observations.pixels.frames().size());
  MotionRefinement report;
  motion::Motion motion = times.measure("refine the motion of " + name, [&] {
    return smoothed_in_time(refine_motion(field, observations, tracked.layer->edges, tracked.layer->node_spacing,
                                          progress, &report, refinement));
  });
  return {{std::move(field), training.rays}, std::move(motion), report};
}

// The training after a draft begins with its field.
void go_on_from(const FieldDraft& draft, fields::TrainerConfig& trainer) {
  trainer.rays -= std::min(draft.rays, trainer.rays);
  trainer.exchange.min_rays = std::max(trainer.exchange.min_rays, draft.rays / 2); // it learns slowly at first
}

// If nodes were moved, nearly all of the draft is right, and it is kept best so.
void learn_slowly(fields::TrainerConfig& trainer) {
  constexpr float kRate = 0.3F;
  trainer.learning_rates.table *= kRate;
  trainer.learning_rates.nets *= kRate;
}

// Asks of the training what the layer's views can hold.
void compare_views(const fields::LayerObservations& observations, const fields::TrainerConfig& usual,
                   LayerOutcome& outcome) {
  outcome.consistency = fields::measure_view_consistency(observations);
  fields::adapt_to(outcome.consistency, usual, outcome.trainer);
}

} // namespace

std::string why_it_moves_so(const TrackedLabel& label, const motion::Motion& motion) {
  if (label.plan.motion == motion::MotionKind::kRigid && motion.kind() == motion::MotionKind::kStill) {
    return fmt::format("label {} is followed as a rigid object but never moves: no motion is stored", label.plan.label);
  }
  if (!label.non_rigidity) return label.plan.why;
  return fmt::format("{}; it bends, from frame {} on by up to {:.1f} cm, and {}", label.plan.why,
                     label.non_rigidity->first_frame, 100 * label.non_rigidity->metres,
                     label.plan.is_specified ? "is kept rigid all the same"
                                             : "so the bending of a graph is tracked instead");
}

LayerOutcome prepare_layer(const LayerJob& job, const fields::LayerObservations& observations,
                           const EncodeOptions& options) {
  LayerOutcome outcome;
  outcome.layer.name = job.name;
  outcome.layer.label = job.label->plan.label;
  outcome.config = fields::choose_field_config(observations, &outcome.requirements);
  const FieldSettings& settings = options.settings.fields;
  outcome.trainer = settings.trainer;
  if (outcome.trainer.rays == 0) {
    outcome.trainer.rays = job.rays;
    outcome.trainer.exchange.decibels_per_second = job.decibels_per_second;
  }
  compare_views(observations, settings.trainer, outcome);
  return outcome;
}

fields::TrainerConfig draft_trainer(const fields::TrainerConfig& trainer) {
  constexpr double kDraftRays = 0.2; // of the layer's (docs/experiments/fields.md)
  fields::TrainerConfig shorter = trainer;
  shorter.rays = static_cast<std::size_t>(kDraftRays * static_cast<double>(trainer.rays));
  shorter.exchange.decibels_per_second /= kDraftRays;
  shorter.max_log2_table_size = 0;
  shorter.quantisation = {};
  return shorter;
}

LayerOutcome train_layer(const LayerJob& job, const fields::PixelStore& pixels, const EncodeOptions& options,
                         StageTimes& times, Progress& progress, const FieldDraft* begin_with) {
  const TrackedLabel& tracked = *job.label;
  const motion::Motion tracked_motion = tracked.motion();
  const fields::LayerObservations as_tracked{pixels, tracked.plan.label, tracked_motion};
  LayerOutcome outcome = prepare_layer(job, as_tracked, options);
  outcome.why = why_it_moves_so(tracked, tracked_motion);
  clip::Layer& layer = outcome.layer;
  layer.joints = tracked.joints();
  const FieldSettings& settings = options.settings.fields;
  if (begin_with != nullptr) {
    outcome.config = begin_with->field.config;
  } else if (options.settings.budget.try_geometries) {
    progress.stage("trying geometries of " + layer.name, 0);
    outcome.geometry = times.measure("try geometries of " + layer.name, [&] {
      return fields::try_geometries(as_tracked, outcome.config, outcome.trainer, progress);
    });
    outcome.config.geometry = outcome.geometry.chosen;
  }
  std::optional<RefinedDraft> refined;
  if (as_tracked.deforms() && begin_with == nullptr) {
    refined = draft_of(outcome, as_tracked, tracked, settings.refinement, times, progress);
    begin_with = &refined->draft;
  }
  layer.motion = refined ? refined->motion : tracked_motion;
  const fields::LayerObservations observations{pixels, layer.label, layer.motion};
  if (refined) {
    outcome.draft = {refined->draft.rays, refined->refinement};
    compare_views(observations, settings.trainer, outcome);
    learn_slowly(outcome.trainer);
  }
  if (begin_with != nullptr) go_on_from(*begin_with, outcome.trainer);
  progress.stage("training " + layer.name, 0);
  layer.field = times.measure("train " + layer.name, [&] {
    return fields::train_field(observations, outcome.config, outcome.trainer, progress, &outcome.training,
                               begin_with != nullptr ? &begin_with->field : nullptr);
  });
  layer.confidence =
      times.measure("confidence of " + layer.name, [&] { return fields::view_confidence(observations, layer.field); });
  return outcome;
}

} // namespace kinora::encode
