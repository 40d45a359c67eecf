#include "fields/training/trainer.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>

#include <fmt/format.h>

#include "core/error.h"
#include "core/parallel.h"
#include "core/random.h"
#include "fields/network/field_batch.h"
#include "fields/training/hidden_cells.h"
#include "fields/training/occupancy_pruning.h"
#include "fields/training/space_carving.h"
#include "fields/training/table_growth.h"

namespace kinora::fields {
namespace {

/// Of a field of signed distances: density falls by half within 0.15 density_length(). It becomes sharper in training.
constexpr float kFirstSharpness = 1.5F;

/// Of the training: from then on the field knows surfaces better than one measurement does (ray_refinement.h).
constexpr double kFused = 0.25;

// Hash entries uniform in ±1e-4 (Müller et al. 2022), nets by Glorot & Bengio 2010.
void initialise(Field& field, std::uint64_t seed) {
  Random random(seed, 0xF1E1D);
  field.sharpness = kFirstSharpness;
  const auto fill = [&random](float* values, std::size_t count, float bound) {
    for (std::size_t i = 0; i < count; ++i) values[i] = bound * (2 * random.uniform() - 1);
  };
  const auto glorot = [](int inputs, int outputs) { return std::sqrt(6.0F / static_cast<float>(inputs + outputs)); };
  constexpr int kH = FieldConfig::kHidden;
  constexpr int kG = FieldConfig::kGeometry;
  constexpr int kC = FieldConfig::kColorHidden;
  const int width = field.config.encoding_width();
  const std::size_t first_size = field.density_net.size() - kH * kG;
  fill(field.table.data(), field.table.size(), 1e-4F);
  fill(field.density_net.data(), first_size, glorot(width, kH));
  fill(field.density_net.data() + first_size, kH * kG, glorot(kH, kG));
  fill(field.color_net.data() + kColorFirst, kG * kC, glorot(kG, kC));
  fill(field.color_net.data() + kColorSecond, kC * kC, glorot(kC, kC));
  fill(field.color_net.data() + kColorThird, kC * FieldConfig::kColorOutputs, glorot(kC, 3));
}

LearningRates scheduled(const TrainerConfig& config, double progress, float rate) {
  const double falling = std::clamp(2 * progress - 1, 0.0, 1.0);
  const double share = 1 - (1 - config.final_learning_rate) * falling;
  const float factor = static_cast<float>(share) * rate;
  return {config.learning_rates.table * factor, config.learning_rates.nets * factor};
}

// Small steps learn the coarse shape with few rays, large ones the detail with little noise: a quarter of the rays of a
// step in the first quarter of the training, half in the second. A warm start knows the shape.
std::size_t chunks_of_step(const TrainerConfig& config, double progress) {
  const auto all = static_cast<std::size_t>(config.rays_per_step / TrainerConfig::kRaysPerChunk);
  return std::max<std::size_t>(1, progress < 0.25 ? all / 4 : progress < 0.5 ? all / 2 : all);
}

std::size_t bytes_of(const Field& field) { return 4 * sizeof(float) * field.parameter_count(); }

/// A field on its way: how far its training has come, and how it goes on.
class TrainingRun {
public:
  /// `warm`: the field has parameters already; otherwise they are random numbers.
  TrainingRun(const RaySampler& sampler, const TrainerConfig& trainer, Field field, bool warm)
      : sampler_(&sampler), trainer_(&trainer),
        length_(trainer.exchange, trainer.rays, sampler.validation_ray_count() >= trainer.min_validation_rays),
        field_(std::make_unique<Field>(std::move(field))), is_warm_start_(warm) {
    start();
  }

  /// The same with twice the entries in the tables.
  TrainingRun with_growth() const {
    TrainingRun larger(*this, std::make_unique<Field>(with_doubled_tables(*field_)));
    larger.length_.forget();
    larger.draw();
    return larger;
  }

  std::size_t rays() const { return rays_; }
  bool is_done() const { return rays_ >= length_.rays(); }
  const TrainingLength& length() const { return length_; }
  void look(double seconds_per_ray) { length_.look({rays_, validation_error()}, seconds_per_ray); }
  const Field& field() const { return *field_; }
  double table_fill() const { return optimizer_->table_fill(); }
  bool is_quantising() const { return optimizer_->is_quantising(); }

  /// `cooling`: progress of a training within this one, which ends with small steps, too.
  StepResult step(Progress& progress, TrainingReport& report, double cooling = 0) {
    const double share = share_done();
    if (share >= trainer_->quantisation.begin && !is_quantising())
      optimizer_->begin_quantisation(trainer_->quantisation);
    rays_ += chunks_of_step(*trainer_, maturity()) * TrainerConfig::kRaysPerChunk;
    ++steps_;
    const StepResult taken = optimizer_->step(scheduled(*trainer_, std::max(share, cooling), rate_), next_rays());
    report.samples += taken.samples;
    report.rays += taken.rays;
    ++report.steps;
    report.final_loss = taken.loss;
    if (const auto collapse = collapse_detector_.collapse(taken); collapse && restarts_ < kMaxRestarts) {
      progress.warn(fmt::format("training stopped learning at step {} ({}); it starts again with smaller steps", steps_,
                                name_of(*collapse)));
      rate_ *= kRestartRate;
      report.restarts.push_back(*collapse);
      ++restarts_;
      is_warm_start_ = false;
      start();
    }
    return taken;
  }

  /// Mean of ‖C − C*‖² over the rays held apart.
  double validation_error() {
    constexpr std::size_t kRays = TrainerConfig::kRaysPerChunk;
    const std::size_t count = sampler_->validation_ray_count();
    FieldOptimizer::Gradient unused;
    const StepResult result =
        optimizer_->gradient({chunk_count(count, kRays),
                              [&](std::size_t chunk, RayBatch& batch) {
                                sampler_->append_validation(chunk * kRays, std::min((chunk + 1) * kRays, count), batch);
                              }},
                             unused);
    draw();
    return result.color_error;
  }

  Field release_field() { return std::move(*field_); }

private:
  static constexpr float kRestartRate = 0.3F; // of the learning rates before
  static constexpr std::size_t kMaxRestarts = 3;

  TrainingRun(const TrainingRun& before, std::unique_ptr<Field> field)
      : sampler_(before.sampler_), trainer_(before.trainer_), length_(before.length_), field_(std::move(field)),
        optimizer_(std::make_unique<FieldOptimizer>(*field_, *before.optimizer_)), rays_(before.rays_),
        steps_(before.steps_), restarts_(before.restarts_), is_warm_start_(before.is_warm_start_), rate_(before.rate_),
        collapse_detector_(before.collapse_detector_) {}

  void start() {
    rays_ = steps_ = 0;
    length_.restart();
    collapse_detector_ = {};
    if (!is_warm_start_) initialise(*field_, trainer_->seed + restarts_);
    optimizer_ = std::make_unique<FieldOptimizer>(*field_, trainer_->loss, trainer_->min_gradient);
    draw();
  }

  void draw() { optimizer_->draw(next_rays()); }
  double share_done() const { return static_cast<double>(rays_) / static_cast<double>(length_.rays()); }
  /// What a training from nothing would have done by now to know the shape as well.
  double maturity() const { return is_warm_start_ ? std::max(0.5, share_done()) : share_done(); }
  StepRays next_rays() const {
    const bool fused = maturity() >= kFused;
    const bool closely = fused && trainer_->exact_depth;
    const std::size_t chunks = share_done() < 1 ? chunks_of_step(*trainer_, maturity()) : 0;
    return {chunks,
            [this, step = steps_, chunks, closely](std::size_t chunk, RayBatch& batch) {
              Random random(mix64(trainer_->seed + 0x7241) + step, chunk);
              sampler_->draw(random, chunk, chunks, TrainerConfig::kRaysPerChunk, trainer_->loss.free_space_rays,
                             closely, batch);
            },
            fused && !trainer_->exact_depth};
  }

  const RaySampler* sampler_;
  const TrainerConfig* trainer_;
  TrainingLength length_;
  std::unique_ptr<Field> field_; // its optimizer knows its address
  std::unique_ptr<FieldOptimizer> optimizer_;
  std::size_t rays_ = 0; // since the last start
  std::size_t steps_ = 0;
  std::size_t restarts_ = 0;
  bool is_warm_start_ = false;
  float rate_ = 1;
  CollapseDetector collapse_detector_;
};

// Whether there are rays enough to learn what larger tables hold.
bool is_long_enough_to_grow(const TrainingRun& training_run, const TrainerConfig& trainer) {
  return training_run.length().rays() >> training_run.field().config.log2_table_size >=
         trainer.table_growth.rays_per_entry;
}

// Whether a training has what a trial needs: rays to judge by, tables that are full, and an error that can be seen.
bool may_grow_tables(TrainingRun& training_run, const RaySampler& sampler, const TrainerConfig& trainer) {
  return sampler.validation_ray_count() >= trainer.min_validation_rays &&
         can_double_tables(training_run.field().config) &&
         training_run.field().config.log2_table_size < trainer.max_log2_table_size &&
         training_run.table_fill() > trainer.table_growth.min_fill &&
         training_run.validation_error() > trainer.table_growth.min_error;
}

// Trains on until so many rays are done, with steps that fall as those of a whole training do, or until learning stops:
// large steps hide what tables hold. Returns the error over the rays held apart.
double error_after(std::size_t end, TrainingRun& training_run, Progress& progress, TrainingReport& report) {
  const std::size_t begin = training_run.rays();
  const std::size_t restarts = report.restarts.size();
  while (training_run.rays() < end && report.restarts.size() == restarts) {
    progress.check();
    training_run.step(progress, report,
                      static_cast<double>(training_run.rays() - begin) / static_cast<double>(end - begin));
  }
  return training_run.validation_error();
}

// Returns whether larger tables paid; the run goes on with them then.
bool try_table_growth(TrainingRun& training_run, const TrainerConfig& trainer, Progress& progress,
                      TrainingReport& report) {
  TableGrowthTrial trial;
  trial.begin = training_run.rays();
  trial.table_fill = training_run.table_fill();
  trial.log2_table_size = training_run.field().config.log2_table_size;
  trial.bytes = bytes_of(training_run.field());
  TrainingRun larger = training_run.with_growth();
  trial.grown_bytes = bytes_of(larger.field());
  const std::size_t end =
      training_run.rays() + std::min(training_run.length().rays() / 8, trainer.table_growth.max_rays);
  TrainingReport aside;
  trial.error = error_after(end, training_run, progress, report);
  trial.grown_error = error_after(end, larger, progress, aside);
  trial.discarded_rays = larger.rays() - trial.begin;
  trial.kept = aside.restarts.empty() && trial.grown_error < trainer.table_growth.worthwhile * trial.error;
  if (trial.kept) training_run = std::move(larger);
  report.table_growth.push_back(trial);
  return trial.kept;
}

double seconds_per_ray(const FieldConfig& config, const TrainingReport& report) {
  return seconds_per_sample(config) * static_cast<double>(report.samples) / static_cast<double>(report.rays);
}

} // namespace

Field train_field(const LayerObservations& layer, const FieldConfig& config, const TrainerConfig& trainer,
                  Progress& progress, TrainingReport* report, const Field* begin_with) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point begin = Clock::now();
  RaySampler sampler(layer, config, trainer.sampling, trainer.loss.noise);
  Field untrained = begin_with != nullptr ? *begin_with : Field(config);
  if (!(untrained.config == config)) {
    throw Error(ErrorCode::kUsage, "a training can only begin with a field of its own configuration");
  }
  untrained.occupancy = sampler.occupancy();
  if (sampler.foreground_ray_count() == 0) {
    throw Error(ErrorCode::kFailure, "a layer without any measured pixel cannot be modelled");
  }
  TrainingReport result;
  TrainingRun training_run(sampler, trainer, std::move(untrained), begin_with != nullptr);
  bool growing = true;
  std::size_t next_trial = training_run.length().rays() / 4;
  for (std::size_t step = 1; !training_run.is_done(); ++step) {
    progress.check();
    if (growing && training_run.rays() >= next_trial && is_long_enough_to_grow(training_run, trainer) &&
        !training_run.is_quantising()) {
      growing =
          may_grow_tables(training_run, sampler, trainer) && try_table_growth(training_run, trainer, progress, result);
      next_trial += training_run.length().rays() / 8;
    }
    if (training_run.length().is_open() && training_run.rays() >= training_run.length().next_look())
      training_run.look(seconds_per_ray(training_run.field().config, result));
    const StepResult taken = training_run.step(progress, result);
    if (step % 64 == 0) progress.advance(training_run.rays(), fmt::format("loss {:.4f}", taken.loss));
  }
  progress.advance(training_run.rays(), fmt::format("loss {:.4f}", result.final_loss));
  result.length = training_run.length().verdict();
  result.looks = training_run.length().looks();
  result.outlook = training_run.length().outlook();
  Field field = training_run.release_field();
  prune_occupancy(field);
  if (trainer.carve_free_space) result.carved_cells = carve_free_space(layer, field);
  if (trainer.empty_hidden_cells) empty_hidden_cells(field);
  result.bytes = bytes_of(field);
  result.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  if (report != nullptr) *report = result;
  return field;
}

} // namespace kinora::fields
