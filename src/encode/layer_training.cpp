#include "encode/layer_training.h"

#include <fmt/format.h>

#include "fields/confidence_of_views.h"

namespace kinora::encode {
namespace {

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

/// What a draft leaves behind.
struct Draft {
  fields::Field field;
  tracking::Motion motion; ///< the layer's, refined
  DraftReport report;
};

Draft draft_of(const LayerOutcome& layer_so_far, const TrackedLabel& tracked, const fields::PixelStore& pixels,
               StageTimes& times, Progress& progress) {
  constexpr double kDraftRays = 0.3; // of the layer's (docs/fields.md)
  const Layer& layer = layer_so_far.layer;
  fields::TrainerConfig shorter = layer_so_far.trainer;
  shorter.rays = static_cast<std::size_t>(kDraftRays * static_cast<double>(layer_so_far.trainer.rays));
  shorter.largest_log2_table_size = 0;
  progress.stage("training a draft of " + layer.name, shorter.rays);
  fields::Field field = times.measure("train a draft of " + layer.name, [&] {
    return fields::train_field(pixels, layer.label, layer.motion, layer_so_far.config, shorter, progress);
  });
  DraftReport report{shorter.rays, {}};
  progress.stage("refining the motion of " + layer.name, pixels.frames().size());
  tracking::Motion motion = times.measure("refine the motion of " + layer.name, [&] {
    return refine_motion(field, pixels, layer.label, layer.motion, tracked.bending->edges(),
                         tracked.bending->node_spacing(), progress, &report.refinement);
  });
  return {std::move(field), std::move(motion), report};
}

// The training after a draft begins with its field, of which nearly all is right.
void go_on_from(const DraftReport& draft, fields::TrainerConfig& trainer) {
  constexpr float kRate = 0.3F;
  trainer.rays -= draft.rays;
  trainer.learning_rates.table *= kRate;
  trainer.learning_rates.nets *= kRate;
}

} // namespace

LayerOutcome train_layer(const LayerJob& job, const fields::PixelStore& pixels, const EncodeOptions& options,
                         StageTimes& times, Progress& progress) {
  const TrackedLabel& tracked = *job.label;
  const int label = tracked.plan.label;
  LayerOutcome outcome;
  Layer& layer = outcome.layer;
  layer.name = job.name;
  layer.label = label;
  layer.motion = tracked.motion();
  layer.joints = tracked.joints();
  outcome.why = reason_of(tracked, layer.motion);
  outcome.config = fields::choose_field_config(pixels, label, layer.motion, &outcome.need);
  outcome.trainer.seed = options.seed;
  outcome.trainer.rays = job.rays;
  const auto compare_views = [&] {
    outcome.agreement = fields::agreement_of_views(pixels, label, layer.motion);
    fields::adapt_to(outcome.agreement, outcome.trainer);
  };
  compare_views();
  if (options.try_geometries) {
    progress.stage("trying geometries of " + layer.name, 0);
    outcome.geometry = times.measure("try geometries of " + layer.name, [&] {
      return fields::try_geometries(pixels, label, layer.motion, outcome.config, outcome.trainer, progress);
    });
  }
  outcome.config.geometry = outcome.geometry.chosen;
  std::optional<fields::Field> begin_with;
  if (layer.motion.kind() == tracking::MotionKind::kDeforming) {
    Draft draft = draft_of(outcome, tracked, pixels, times, progress);
    layer.motion = std::move(draft.motion);
    begin_with = std::move(draft.field);
    outcome.draft = draft.report;
    compare_views();
    go_on_from(*outcome.draft, outcome.trainer);
  }
  progress.stage("training " + layer.name, outcome.trainer.rays);
  layer.field = times.measure("train " + layer.name, [&] {
    return fields::train_field(pixels, label, layer.motion, outcome.config, outcome.trainer, progress,
                               &outcome.training, begin_with ? &*begin_with : nullptr);
  });
  layer.confidence = times.measure("confidence of " + layer.name, [&] {
    return fields::confidence_of_views(pixels, label, layer.motion, layer.field);
  });
  return outcome;
}

} // namespace kinora::encode
