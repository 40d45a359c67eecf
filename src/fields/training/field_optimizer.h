// One training step: forward, loss, backward and Adam over chunks of rays, on all threads.
#pragma once

#include <functional>
#include <memory>

#include "fields/model/field.h"
#include "fields/network/ray_batch.h"
#include "fields/training/loss.h"

namespace kinora::fields {

struct LearningRates {
  float table = 0.03F;
  float nets = 0.005F;
};

/// Tables rounded while they are trained: what the forward pass reads are multiples of a power of two, one for each
/// level, as a file stores them, so that the rest of the field learns to live with that and steps may be coarser than
/// those of a field that is rounded afterwards.
struct TableQuantisation {
  double begin = 1;        ///< share of the training from which on; 1: never
  double coarse_steps = 2; ///< in the root mean square of a level of the coarser half, or less than twice as many
  double fine_steps = 0.5; ///< of the finer half
  double up_from = 0.55;   ///< what is left of a step that counts as one more: above a half, small values cost less
};

struct StepResult {
  double loss = 0;           ///< mean over the rays
  double opacity = 0;        ///< mean over the layer's own rays; near zero for a field that died
  double color_error = 0;    ///< mean of ‖C − C*‖² over the own rays
  double color_variance = 0; ///< the same of the best constant colour: a field that is no better knows nothing
  std::size_t rays = 0;
  std::size_t samples = 0;
};

/// The rays of a step: `fill(chunk, batch)` provides those of each of `chunks` chunks; called once for each, on any
/// thread. Chunks that were never filled have no rays. `refined`: measured rays are refined by the field
/// (ray_refinement.h).
struct StepRays {
  std::size_t chunks = 0;
  std::function<void(std::size_t, RayBatch&)> fill;
  bool refined = false;
};

/// Owns gradients and moments; the field is the caller's and must outlive it. Not thread-safe; uses threads inside.
/// Same input, same bits, for any number of threads: chunks are fixed, their net gradients are merged in order, and
/// each level of the grid is scattered to by one task in order of the samples.
class FieldOptimizer {
public:
  /// Samples whose gradients are all below `min_gradient` shares of a ray's weight in the mean are left out of the
  /// backward pass: those that light does not reach, and empty ones. 0: none are.
  FieldOptimizer(Field& field, const LossWeights& weights, float min_gradient = 0);
  /// Goes on where `before` is, with its field's tables doubled in `field`; has no rays. `before` must not quantise.
  FieldOptimizer(Field& field, const FieldOptimizer& before);
  ~FieldOptimizer();

  /// Draws the rays of the next step.
  void draw(const StepRays& rays);
  /// Takes a step with the rays that were drawn last, and draws `next`: there is always something to draw while the
  /// levels of the grid, few and of unequal cost, are worked on.
  StepResult step(const LearningRates& rates, const StepRays& next);

  /// From now on the field's tables are rounded, with the steps that their values call for now; steps move values
  /// behind them that are not (a straight-through estimator).
  void begin_quantisation(const TableQuantisation& quantisation);
  bool is_quantising() const;

  /// The loss of a step and its gradient, without changing the field: what tests compare with the reference.
  /// Rays that were drawn for the next step are lost.
  struct Gradient {
    std::vector<float> table, density_net, color_net;
    float sharpness = 0;
  };
  StepResult gradient(const StepRays& rays, Gradient& gradient);

  /// Share of the finest level's entries that a gradient has reached: where all were, many vertices share each.
  double table_fill() const;

private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

} // namespace kinora::fields
