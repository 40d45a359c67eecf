// Trains the field of one layer from stored pixels, through the layer's motion.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/progress.h"
#include "fields/model/field.h"
#include "fields/sampling/layer_observations.h"
#include "fields/sampling/ray_sampler.h"
#include "fields/training/collapse.h"
#include "fields/training/field_optimizer.h"
#include "fields/training/loss.h"
#include "fields/training/training_length.h"

namespace kinora::fields {

/// When tables are tried with twice the entries (TableGrowthTrial), and kept.
struct GrowthConfig {
  std::size_t rays_per_entry = 192; ///< of the whole training: shorter ones end before larger tables pay
  double min_fill = 0.5;            ///< share of the entries in use
  double min_error = 3e-4;          ///< mean squared error of the colour of validation rays that is worth a trial
  double worthwhile = 0.96;         ///< of the error; less is not worth the memory
  std::size_t max_rays = 500'000;   ///< of a trial
};

/// Every number a run depends on; written into the clip. Lengths in metres, learning rates for Adam.
struct TrainerConfig {
  std::uint64_t seed = 1;
  std::size_t rays = 20'000'000; ///< rays in the whole training of the layer; at most, if `exchange` asks for a gain
  ExchangeRate exchange;
  std::size_t min_validation_rays = 256; ///< to judge length and tables by
  int rays_per_step = 4096; ///< of the later steps, a multiple of kRaysPerChunk; the first ones take a quarter
  LearningRates learning_rates;
  float final_learning_rate =
      0.02F; ///< share that is left at the end; constant for the first half, then falling evenly
  LossWeights loss;
  SamplingConfig sampling;
  float min_gradient = 1e-4F;   ///< FieldOptimizer
  int max_log2_table_size = 17; ///< up to which tables may grow (TableGrowthTrial)
  GrowthConfig table_growth;
  TableQuantisation quantisation; ///< while it goes on no tables grow
  bool carve_free_space = true;   ///< in the end; finds nothing where all views agree
  bool empty_hidden_cells = true; ///< in the end: what nobody sees takes room in the file
  bool exact_depth = false;       ///< later steps sample closely about measured depths; else these are refined first

  static constexpr int kRaysPerChunk = 128;
};

/// What a field's size is chosen from.
struct FieldRequirements {
  std::size_t points = 0;   ///< measured points of the layer that were looked at
  double footprint = 0;     ///< metres of a pixel at the surface, for the nearest quarter of them
  double surface_cells = 0; ///< cells of the finest level that the surface passes through
};

/// Chooses box, resolution and table size from the layer's observed surface: its measured pixels carried into canonical
/// space, and the finest pixel footprint among them. Throws Error(kFailure) if the layer has no measured pixel.
FieldConfig choose_field_config(const LayerObservations& layer, FieldRequirements* requirements = nullptr);

/// After a part of the training it goes on twice over the same rays: with the tables as they are, and with twice the
/// entries. What draws rays held apart better by enough is kept.
struct TableGrowthTrial {
  std::size_t begin = 0;          ///< rays that had been trained
  std::size_t discarded_rays = 0; ///< rays that taught what was thrown away
  double table_fill = 0;          ///< FieldOptimizer::table_fill before
  int log2_table_size = 0;        ///< before
  std::size_t bytes = 0;          ///< as TrainingReport::bytes, before
  std::size_t grown_bytes = 0;    ///< and with twice the entries
  double error = 0;               ///< mean of ‖C − C*‖² over the rays held apart, with tables as they are
  double grown_error = 0;         ///< and with twice the entries
  bool kept = false;              ///< whether the tables grew
};

struct TrainingReport {
  std::size_t rays = 0;
  std::size_t samples = 0;
  std::size_t steps = 0;
  std::size_t bytes = 0; ///< of parameters, their gradients and both moments: what a step works on
  double seconds = 0;    ///< for people; no decision depends on it
  double final_loss = 0;
  std::vector<Collapse> restarts; ///< why the field was begun anew, each time
  std::size_t carved_cells = 0;   ///< that were dropped
  std::vector<TableGrowthTrial> table_growth;
  LengthVerdict length = LengthVerdict::kAsked; ///< why it ended
  std::vector<TrainingLook> looks;              ///< at its error, if its length was chosen
  TrainingOutlook outlook;                      ///< at the last of them
};

/// Returns the trained field with its occupancy; its tables may have grown (TableGrowthTrial). `begin_with`: a field of
/// that configuration which was trained before, with fewer frames or another motion: it is learnt on from there, and as
/// sharply at once as a training from nothing does from its middle on (a warm start). Learning rates of 0.3 keep better
/// what is known, and learn more slowly what is new. Same input, same bits, for any number of threads. Throws
/// Error(kInterrupted) when cancelled, Error(kUsage) if `begin_with` has another configuration.
Field train_field(const LayerObservations& layer, const FieldConfig& config, const TrainerConfig& trainer,
                  Progress& progress, TrainingReport* report = nullptr, const Field* begin_with = nullptr);

} // namespace kinora::fields
