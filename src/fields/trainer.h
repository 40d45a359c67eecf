// Trains the field of one layer from stored pixels, through the layer's motion.
#pragma once

#include <cstdint>
#include <string>

#include "core/progress.h"
#include "fields/field.h"
#include "fields/optimizer.h"
#include "fields/pixel_store.h"
#include "fields/ray_sampler.h"
#include "tracking/motion.h"

namespace kinora::fields {

/// Every number a run depends on; written into the clip. Lengths in metres, learning rates for Adam.
struct TrainerConfig {
  std::uint64_t seed = 1;
  std::size_t rays = 20'000'000; ///< rays in the whole training of the layer
  int rays_per_step = 4096;      ///< of the later steps, a multiple of kRaysPerChunk; the first ones take a quarter
  LearningRates learning_rates;
  float final_learning_rate = 0.05F; ///< share that is left at the end; constant for the first half, then falling
  LossWeights loss;
  SamplingConfig sampling;
  float negligible_gradient = 1e-4F; ///< FieldOptimizer

  static constexpr int kRaysPerChunk = 128;
};

/// Chooses box, resolution and table size from the layer's observed surface: the measured pixels of `label` carried
/// into canonical space, and the finest pixel footprint among them. `label` 0 takes all pixels when nothing is
/// labelled. Throws Error(kFailure) if the layer has no measured pixel.
FieldConfig choose_field_config(const PixelStore& pixels, int label, const tracking::Motion& motion);

struct TrainingReport {
  std::size_t rays = 0;
  std::size_t samples = 0;
  std::size_t steps = 0;
  std::size_t bytes = 0; ///< of parameters, their gradients and both moments: what a step works on
  double seconds = 0;    ///< for people; no decision depends on it
  double final_loss = 0;
  std::size_t restarts = 0; ///< times a dead or diverged field was begun anew
};

/// Returns the trained field with its occupancy. Same input, same bits, for any number of threads.
/// Throws Error(kInterrupted) when cancelled.
Field train_field(const PixelStore& pixels, int label, const tracking::Motion& motion, const FieldConfig& config,
                  const TrainerConfig& trainer, Progress& progress, TrainingReport* report = nullptr);

} // namespace kinora::fields
