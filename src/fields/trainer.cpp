#include "fields/trainer.h"

#include <chrono>
#include <cmath>

#include <fmt/format.h>

#include "core/error.h"
#include "core/parallel.h"
#include "fields/field_batch.h"

namespace kinora::fields {
namespace {

/// Of a field of signed distances: density falls by half within 0.15 density_length(). It becomes sharper in training.
constexpr float kFirstSharpness = 1.5F;

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

LearningRates scheduled(const TrainerConfig& config, double progress, float restart_factor) {
  const double decay = progress < 0.5 ? 1.0 : std::pow(config.final_learning_rate, 2 * (progress - 0.5));
  const float factor = static_cast<float>(decay) * restart_factor;
  return {config.learning_rates.table * factor, config.learning_rates.nets * factor};
}

// Small steps learn the coarse shape with few rays, large ones the detail with little noise: a quarter of the rays of a
// step in the first quarter of the training, half in the second.
std::size_t chunks_of_step(const TrainerConfig& config, double progress) {
  const auto all = static_cast<std::size_t>(config.rays_per_step / TrainerConfig::kRaysPerChunk);
  return std::max<std::size_t>(1, progress < 0.25 ? all / 4 : progress < 0.5 ? all / 2 : all);
}

// Notices a field that diverged, that gave up being opaque anywhere, or whose colour is the same everywhere: too large
// steps leave rectifiers that no gradient reaches any more, and every number finite.
class Pulse {
public:
  bool is_dead(const StepResult& step) {
    constexpr std::size_t kFirstSteps = 200; // in which nothing can be expected yet
    constexpr double kMemory = 1.0 / 64;
    constexpr double kShare = 0.9;       // of the colours' variance that a field at least explains a tenth of
    constexpr double kNoContrast = 3e-3; // a variance that may be all noise: 8 of 255 in each channel
    if (!std::isfinite(step.loss)) return true;
    unexplained_ += kMemory * (step.color_error - kShare * step.color_variance - unexplained_);
    const bool constant = unexplained_ > 0 && step.color_variance > kNoContrast;
    return ++steps_ > kFirstSteps && (step.opacity < 0.02 || constant);
  }

private:
  std::size_t steps_ = 0;
  double unexplained_ = 0; // mean of the last steps
};

// Keeps the cells in which the field absorbs anything worth drawing.
void prune(Field& field) {
  constexpr int kProbes = 8;
  constexpr float kVisible = 0.02F; // opacity of a cell's side
  const int resolution = field.config.occupancy_resolution;
  const float cell = static_cast<float>(field.config.box.side / resolution / field.config.density_length());
  const std::vector<GridLevel> levels = grid_levels(field.config);
  std::vector<std::uint64_t>& words = field.occupancy.words();
  parallel_for(words.size(), 256, [&](const Chunk& chunk) {
    std::vector<float> x, y, z;
    std::vector<std::size_t> bits;
    PointBatch batch;
    Random random(0x9A11, chunk.index);
    for (std::size_t w = chunk.begin; w < chunk.end; ++w) {
      for (int b = 0; b < 64; ++b) {
        if (((words[w] >> b) & 1) == 0) continue;
        const std::size_t index = w * 64 + static_cast<std::size_t>(b);
        const std::size_t r = static_cast<std::size_t>(resolution);
        const std::size_t cell_x = index % r;
        const std::size_t cell_y = index / r % r;
        const std::size_t cell_z = index / (r * r);
        for (int k = 0; k < kProbes; ++k) {
          x.push_back((static_cast<float>(cell_x) + random.uniform()) / static_cast<float>(resolution));
          y.push_back((static_cast<float>(cell_y) + random.uniform()) / static_cast<float>(resolution));
          z.push_back((static_cast<float>(cell_z) + random.uniform()) / static_cast<float>(resolution));
        }
        bits.push_back(index);
      }
    }
    evaluate_points(field, levels, {x.data(), y.data(), z.data(), x.size()}, batch);
    for (std::size_t i = 0; i < bits.size(); ++i) {
      float densest = 0;
      for (std::size_t k = 0; k < kProbes; ++k) {
        const float raw = batch.geometry[(i * kProbes + k) * FieldConfig::kGeometry];
        densest = std::max(densest, std::exp(std::min(raw, kMaxRawDensity)));
      }
      if (1 - std::exp(-densest * cell) < kVisible) words[bits[i] >> 6] &= ~(std::uint64_t{1} << (bits[i] & 63));
    }
  });
}

} // namespace

Field train_field(const PixelStore& pixels, int label, const tracking::Motion& motion, const FieldConfig& config,
                  const TrainerConfig& trainer, Progress& progress, TrainingReport* report) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point begin = Clock::now();
  constexpr float kRestartFactor = 0.3F;
  constexpr std::size_t kMaxRestarts = 3;
  RaySampler sampler(pixels, label, motion, config, trainer.sampling);
  Field field(config);
  field.occupancy = sampler.seed_occupancy();
  sampler.set_occupancy(field.occupancy);
  if (sampler.own_ray_count() == 0) {
    throw Error(ErrorCode::kFailure, "a layer without any measured pixel cannot be modelled");
  }

  TrainingReport result;
  float restart_factor = 1;
  initialise(field, trainer.seed);
  auto optimizer = std::make_unique<FieldOptimizer>(field, trainer.loss, trainer.negligible_gradient);
  const std::size_t wanted = std::max<std::size_t>(trainer.rays, 1);
  const auto share_of = [wanted](std::size_t done) { return static_cast<double>(done) / static_cast<double>(wanted); };
  const auto rays_of = [&](std::size_t step, std::size_t done) {
    const std::size_t chunks = done < wanted ? chunks_of_step(trainer, share_of(done)) : 0;
    return StepRays{chunks, [&sampler, &trainer, step, chunks](std::size_t chunk, RayBatch& batch) {
                      Random random(mix64(trainer.seed + 0x7241) + step, chunk);
                      sampler.draw(random, chunk, chunks, TrainerConfig::kRaysPerChunk, batch);
                    }};
  };
  std::size_t done = 0; // rays since the last start
  std::size_t step = 0;
  Pulse pulse;
  optimizer->draw(rays_of(step, done));
  while (done < wanted) {
    progress.check();
    const LearningRates rates = scheduled(trainer, share_of(done), restart_factor);
    done += chunks_of_step(trainer, share_of(done)) * TrainerConfig::kRaysPerChunk;
    ++step;
    const StepResult taken = optimizer->step(rates, rays_of(step, done));
    result.samples += taken.samples;
    result.rays += taken.rays;
    ++result.steps;
    result.final_loss = taken.loss;
    if (pulse.is_dead(taken) && result.restarts < kMaxRestarts) {
      progress.warn(fmt::format("training stopped learning at step {}; it starts again with smaller steps", step));
      ++result.restarts;
      restart_factor *= kRestartFactor;
      initialise(field, trainer.seed + result.restarts);
      optimizer = std::make_unique<FieldOptimizer>(field, trainer.loss, trainer.negligible_gradient);
      done = 0;
      step = 0;
      pulse = {};
      optimizer->draw(rays_of(step, done));
    }
    if (step % 64 == 0 || done >= wanted) progress.advance(done, fmt::format("loss {:.4f}", taken.loss));
  }
  prune(field);
  result.bytes = 4 * sizeof(float) * field.parameter_count();
  result.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  if (report != nullptr) *report = result;
  return field;
}

} // namespace kinora::fields
