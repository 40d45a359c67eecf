// One layer's way from a followed label to a field: its size, what may be asked of its views, its geometry, a draft
// that refines the motion of what deforms, and the training.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "clip/clip.h"
#include "core/progress.h"
#include "encode/encode_options.h"
#include "encode/motion_refinement.h"
#include "encode/stage_times.h"
#include "encode/training_plan.h"
#include "fields/planning/geometry_trial.h"
#include "fields/planning/view_consistency.h"
#include "fields/training/trainer.h"

namespace kinora::encode {

/// A short training with the tracker's motion, and that motion aligned through what was learnt.
struct DraftReport {
  std::size_t rays = 0; ///< of the draft: they count as the layer's
  MotionRefinement refinement;
};

/// A field to learn on from.
struct FieldDraft {
  fields::Field field;
  std::size_t rays = 0; ///< that taught it: they count as the layer's
};

/// A layer, and all that was chosen and measured on its way.
struct LayerOutcome {
  clip::Layer layer;
  std::string why; ///< it moves as it does; one sentence
  fields::FieldRequirements requirements;
  fields::FieldConfig config; ///< that training began with
  fields::ViewConsistency consistency;
  fields::GeometryTrial geometry;
  std::optional<DraftReport> draft; ///< only of a layer that deforms
  fields::TrainerConfig trainer;    ///< of the training after the draft
  fields::TrainingReport training;
};

/// One sentence for the report.
std::string why_it_moves_so(const TrackedLabel& label, const motion::Motion& motion);

/// What is chosen before anything is trained: all but the layer's motion and field. Throws Error(kFailure) if the label
/// has no measured pixel.
LayerOutcome prepare_layer(const LayerJob& job, const fields::LayerObservations& observations,
                           const EncodeOptions& options);
/// Of a draft of a layer that would be trained so.
fields::TrainerConfig draft_trainer(const fields::TrainerConfig& trainer);

/// `begin_with`: a draft of the layer, if there is one already. Same input, same layer, for any number of threads; only
/// `times` differ. Throws Error: kFailure if the label has no measured pixel, kInterrupted.
LayerOutcome train_layer(const LayerJob& job, const fields::PixelStore& pixels, const EncodeOptions& options,
                         StageTimes& times, Progress& progress, const FieldDraft* begin_with = nullptr);

} // namespace kinora::encode
