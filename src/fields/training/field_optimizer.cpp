#include "fields/training/field_optimizer.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <utility>

#include "core/parallel.h"
#include "fields/network/field_batch.h"
#include "fields/network/flush_to_zero.h"
#include "fields/network/hash_grid.h"
#include "fields/network/mlp.h"
#include "fields/network/vector_features.h"
#include "fields/network/volume_density.h"
#include "fields/training/adam.h"
#include "fields/training/compositing.h"
#include "fields/training/ray_refinement.h"
#include "fields/training/table_growth.h"

namespace kinora::fields {
namespace {

constexpr int kF = FieldConfig::kFeatures;
constexpr int kH = FieldConfig::kHidden;
constexpr int kG = FieldConfig::kGeometry;
constexpr int kC = FieldConfig::kColorHidden;
constexpr int kO = FieldConfig::kColorOutputs;

/// Weights with inputs and outputs exchanged, for gradients of inputs.
struct TransposedNets {
  std::vector<float> density; // kGeometry × kHidden, then kHidden × encoding width
  std::vector<float> color;   // third, second, first

  explicit TransposedNets(const Field& field) {
    const int width = field.config.encoding_width();
    append_transposed(field.density_net.data() + width * kH, kH, kG, density);
    append_transposed(field.density_net.data(), width, kH, density);
    append_transposed(field.color_net.data() + kColorThird, kC, kO, color);
    append_transposed(field.color_net.data() + kColorSecond, kC, kC, color);
    append_transposed(field.color_net.data() + kColorFirst, kG, kC, color);
  }
};

/// What one chunk of rays leaves for the end of the step; kept from step to step.
struct ChunkWork {
  RayBatch rays;
  std::vector<float> x, y, z, length; // per sample; after the backward pass x, y and z of those that matter
  std::size_t active = 0;
  std::vector<float> encoding_gradient; // of the samples that matter
  std::vector<float> density_net_gradient, color_net_gradient;
  double loss = 0;
  double sharpness_gradient = 0;
  ColorSums colors;
  double foreground_opacity = 0;
  std::size_t foreground_rays = 0;

  kernels::Points points(std::size_t count) const { return {x.data(), y.data(), z.data(), count}; }
  void gather_samples() {
    const std::size_t n = rays.samples.size();
    for (std::vector<float>* values : {&x, &y, &z, &length}) values->resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      const RaySample& sample = rays.samples[i];
      x[i] = sample.position[0];
      y[i] = sample.position[1];
      z[i] = sample.position[2];
      length[i] = sample.length;
    }
  }
};

/// What is done with when the chunk is: one for each thread, so that it stays in its cache.
struct Scratch {
  RefinementScratch refinement;
  PointBatch points;
  ColorBatch color;
  Composition composition;
  std::vector<float> color_gradient, second_gradient, first_gradient, input_gradient;
  std::vector<float> geometry_gradient, hidden_gradient;
  std::vector<std::uint32_t> active;
};

struct Moments {
  LargeBuffer<float> gradient, first, second;
  explicit Moments(std::size_t size) : gradient(size, 0.0F), first(size, 0.0F), second(size, 0.0F) {}
};

/// Moves row `from` of width floats to row `to`.
void move_row(std::vector<float>& rows, std::size_t from, std::size_t to, std::size_t width) {
  std::copy_n(rows.begin() + static_cast<std::ptrdiff_t>(from * width), width,
              rows.begin() + static_cast<std::ptrdiff_t>(to * width));
}

void add_to(LargeBuffer<float>& sum, const std::vector<float>& values) {
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += values[i];
}

/// kernels::adam for a single parameter.
void adam_scalar(const kernels::AdamStep& step, float gradient, float& parameter, std::array<float, 2>& moments) {
  moments[0] += (1 - step.beta1) * (gradient - moments[0]);
  moments[1] += (1 - step.beta2) * (gradient * gradient - moments[1]);
  parameter -= step.learning_rate * moments[0] / (std::sqrt(moments[1]) + step.epsilon);
}

/// Within what kernels::Quantiser takes; the least for 0.
float power_of_two_below(double size) {
  constexpr int kLargest = 100;
  const int exponent = size > 0 ? std::clamp(std::ilogb(size), -kLargest, kLargest) : -kLargest;
  return std::ldexp(1.0F, exponent);
}

// Of the own rays.
void rotate_rows(const RayBatch& rays, bool back, float* rows) {
  for (const RayTarget& target : rays.targets) {
    if (!target.foreground) continue;
    rotate_vectors(back ? inverse_rotation(target.rotation) : target.rotation, rows);
    rows += kG;
  }
}

// Calls task(0), task(1), … on all threads; each begins when those before it have begun.
void run_in_order(std::size_t tasks, const std::function<void(std::size_t)>& task) {
  std::atomic<std::size_t> next = 0;
  parallel_for(static_cast<std::size_t>(thread_count()), 1, [&](const Chunk&) {
    for (std::size_t i = next++; i < tasks; i = next++) task(i);
  });
}

} // namespace

struct FieldOptimizer::Implementation {
  Field& field;
  LossWeights weights;
  float min_gradient;
  std::vector<GridLevel> levels;
  Moments table, density_net, color_net;
  LargeBuffer<float> latent;                  // tables before they are rounded
  std::vector<kernels::Quantiser> quantisers; // of each level; none: tables are not rounded
  std::vector<ChunkWork> work;
  std::size_t drawn = 0; // chunks whose rays wait for the next step
  bool refined = false;  // whether these are to be refined
  long steps = 0;
  float sharpness_gradient = 0;
  std::array<float, 2> sharpness_moments{};

  Implementation(Field& f, const LossWeights& w, float n)
      : field(f), weights(w), min_gradient(n), levels(grid_levels(f.config)), table(f.table.size()),
        density_net(f.density_net.size()), color_net(f.color_net.size()) {}

  void forward_backward(ChunkWork& chunk, const TransposedNets& transposed, float scale) const;
  void color_backward(ChunkWork& chunk, Scratch& scratch, const TransposedNets& transposed) const;
  void keep_active(ChunkWork& chunk, Scratch& scratch, float scale) const;
  void points_backward(ChunkWork& chunk, Scratch& scratch, const TransposedNets& transposed) const;
  void draw(const StepRays& rays, std::size_t chunk);
  void scatter(std::size_t level, std::size_t chunks);
  StepResult accumulate(const std::function<void(std::size_t)>& after_level, const StepRays& next);
  void merge(std::size_t chunks, StepResult& result);

  void update_level(const kernels::AdamStep& step, std::size_t level);
  double root_mean_square(std::size_t level) const;
  /// Of a level's parameters in the table.
  std::size_t begin_of(std::size_t level) const { return static_cast<std::size_t>(levels[level].offset) * kF; }
  std::size_t size_of(std::size_t level) const { return static_cast<std::size_t>(levels[level].size) * kF; }

  void prepare(const StepRays& rays) {
    drawn = rays.chunks;
    refined = rays.refined;
    if (work.size() < drawn) work.resize(drawn);
  }
};

void FieldOptimizer::Implementation::color_backward(ChunkWork& chunk, Scratch& scratch,
                                                    const TransposedNets& transposed) const {
  const std::size_t n = scratch.composition.foreground_rays;
  scratch.second_gradient.resize(n * kC);
  scratch.first_gradient.resize(n * kC);
  scratch.input_gradient.resize(n * kG);
  float* gradient = chunk.color_net_gradient.data();
  const float* third_t = transposed.color.data();
  const float* second_t = third_t + kC * kO;
  const float* first_t = second_t + kC * kC;
  kernels::accumulate_weight_gradient(scratch.color.second.data(), scratch.color_gradient.data(), n, kC, kO,
                                      gradient + kColorThird);
  kernels::dense(scratch.color_gradient.data(), n, kO, third_t, kC, false, scratch.second_gradient.data());
  kernels::relu_backward(scratch.color.second.data(), n * kC, scratch.second_gradient.data());
  kernels::accumulate_weight_gradient(scratch.color.first.data(), scratch.second_gradient.data(), n, kC, kC,
                                      gradient + kColorSecond);
  kernels::dense(scratch.second_gradient.data(), n, kC, second_t, kC, false, scratch.first_gradient.data());
  kernels::relu_backward(scratch.color.first.data(), n * kC, scratch.first_gradient.data());
  kernels::accumulate_weight_gradient(scratch.color.input.data(), scratch.first_gradient.data(), n, kG, kC,
                                      gradient + kColorFirst);
  kernels::dense(scratch.first_gradient.data(), n, kC, first_t, kG, false, scratch.input_gradient.data());
}

void FieldOptimizer::Implementation::keep_active(ChunkWork& chunk, Scratch& scratch, float scale) const {
  const std::size_t n = chunk.rays.samples.size();
  chunk.active = n;
  if (min_gradient <= 0) return;
  scratch.active.resize(n);
  chunk.active = kernels::rows_above(scratch.geometry_gradient.data(), n, min_gradient * scale, scratch.active.data());
  for (std::size_t to = 0; to < chunk.active; ++to) {
    const std::size_t from = scratch.active[to];
    if (from == to) continue;
    chunk.x[to] = chunk.x[from];
    chunk.y[to] = chunk.y[from];
    chunk.z[to] = chunk.z[from];
    move_row(scratch.points.encoding, from, to, levels.size() * kF);
    move_row(scratch.points.hidden, from, to, kH);
    move_row(scratch.geometry_gradient, from, to, kG);
  }
}

// A block of points at a time: what one matrix leaves is still at hand for the next.
void FieldOptimizer::Implementation::points_backward(ChunkWork& chunk, Scratch& scratch,
                                                     const TransposedNets& transposed) const {
  const std::size_t n = chunk.active;
  const int width = field.config.encoding_width();
  scratch.hidden_gradient.resize(kPointBlock * kH);
  chunk.encoding_gradient.resize(n * static_cast<std::size_t>(width));
  float* net_gradient = chunk.density_net_gradient.data();
  float* hidden_gradient = scratch.hidden_gradient.data();
  for (std::size_t begin = 0; begin < n; begin += kPointBlock) {
    const std::size_t count = std::min(kPointBlock, n - begin);
    const float* encoding = scratch.points.encoding.data() + begin * static_cast<std::size_t>(width);
    const float* hidden = scratch.points.hidden.data() + begin * kH;
    const float* geometry_gradient = scratch.geometry_gradient.data() + begin * kG;
    kernels::accumulate_weight_gradient(hidden, geometry_gradient, count, kH, kG, net_gradient + width * kH);
    kernels::dense(geometry_gradient, count, kG, transposed.density.data(), kH, false, hidden_gradient);
    kernels::relu_backward(hidden, count * kH, hidden_gradient);
    kernels::accumulate_weight_gradient(encoding, hidden_gradient, count, width, kH, net_gradient);
    kernels::dense(hidden_gradient, count, kH, transposed.density.data() + kG * kH, width, false,
                   chunk.encoding_gradient.data() + begin * static_cast<std::size_t>(width));
  }
}

void FieldOptimizer::Implementation::forward_backward(ChunkWork& chunk, const TransposedNets& transposed,
                                                      float scale) const {
  static thread_local Scratch scratch;
  if (refined) refine_rays(field, levels, chunk.rays, scratch.refinement);
  chunk.gather_samples();
  chunk.density_net_gradient.assign(field.density_net.size(), 0.0F);
  chunk.color_net_gradient.assign(field.color_net.size(), 0.0F);
  evaluate_points(field, levels, chunk.points(chunk.rays.samples.size()), scratch.points);
  const float* geometry = scratch.points.geometry.data();
  composite(chunk.rays, chunk.length, geometry, weights, scratch.composition, scratch.color.input);
  rotate_rows(chunk.rays, false, scratch.color.input.data());
  evaluate_colors(field, scratch.composition.foreground_rays, scratch.color);
  chunk.colors = compare_colors(chunk.rays, scratch.color.output.data(), weights, scale, scratch.color_gradient);
  chunk.loss = scratch.composition.loss + static_cast<double>(weights.color) * chunk.colors.squared_error;
  chunk.foreground_opacity = scratch.composition.foreground_opacity;
  chunk.foreground_rays = scratch.composition.foreground_rays;
  color_backward(chunk, scratch, transposed);
  rotate_rows(chunk.rays, true, scratch.color.input.data());
  rotate_rows(chunk.rays, true, scratch.input_gradient.data());
  scratch.geometry_gradient.resize(chunk.rays.samples.size() * kG);
  composite_backward(chunk.rays, geometry, weights, scale, scratch.composition, scratch.color.input,
                     scratch.input_gradient.data(), scratch.geometry_gradient.data());
  if (field.config.geometry == Geometry::kSignedDistance) {
    const std::span<const float> distances(scratch.points.distance.data(), chunk.rays.samples.size());
    chunk.sharpness_gradient = through_density(distances, field.sharpness, scratch.geometry_gradient.data());
    chunk.loss += distance_loss(chunk.rays, scratch.points.distance, weights, scale, scratch.geometry_gradient.data());
  }
  keep_active(chunk, scratch, scale);
  points_backward(chunk, scratch, transposed);
}

void FieldOptimizer::Implementation::draw(const StepRays& rays, std::size_t chunk) {
  work[chunk].rays.clear();
  rays.fill(chunk, work[chunk].rays);
}

void FieldOptimizer::Implementation::scatter(std::size_t level, std::size_t chunks) {
  float* gradient = table.gradient.data() + static_cast<std::size_t>(levels[level].offset) * kF;
  for (std::size_t c = 0; c < chunks; ++c) {
    const ChunkWork& chunk = work[c];
    kernels::scatter_level(levels[level], chunk.points(chunk.active), chunk.encoding_gradient.data() + level * kF,
                           levels.size() * kF, gradient);
  }
}

StepResult FieldOptimizer::Implementation::accumulate(const std::function<void(std::size_t)>& after_level,
                                                      const StepRays& next) {
  const std::size_t chunks = drawn;
  StepResult result;
  for (std::size_t c = 0; c < chunks; ++c) {
    result.rays += work[c].rays.ray_count();
    result.samples += work[c].rays.samples.size();
  }
  if (result.rays > 0) {
    const TransposedNets transposed(field);
    const float scale = 1.0F / static_cast<float>(result.rays);
    parallel_for(chunks, 1, [&](const Chunk& c) {
      const FlushToZero flush;
      forward_backward(work[c.index], transposed, scale);
    });
    merge(chunks, result);
  }
  // The finest levels first: they take longest. Rays are no longer needed by then, and make room for the next.
  const std::size_t touched = result.rays > 0 ? levels.size() : 0;
  prepare(next);
  run_in_order(touched + next.chunks, [&](std::size_t task) {
    const FlushToZero flush;
    if (task >= touched) return draw(next, task - touched);
    const std::size_t level = levels.size() - 1 - task;
    scatter(level, chunks);
    after_level(level);
  });
  return result;
}

void FieldOptimizer::Implementation::merge(std::size_t chunks, StepResult& result) {
  double opacity = 0;
  double foreground = 0;
  ColorSums colors;
  for (std::size_t c = 0; c < chunks; ++c) {
    add_to(density_net.gradient, work[c].density_net_gradient);
    add_to(color_net.gradient, work[c].color_net_gradient);
    sharpness_gradient += static_cast<float>(work[c].sharpness_gradient);
    result.loss += work[c].loss / static_cast<double>(result.rays);
    colors.add(work[c].colors);
    opacity += work[c].foreground_opacity;
    foreground += static_cast<double>(work[c].foreground_rays);
  }
  if (foreground == 0) return;
  result.opacity = opacity / foreground;
  result.color_error = colors.squared_error / foreground;
  result.color_variance = colors.squared_target / foreground;
  for (const double sum : colors.target) result.color_variance -= (sum / foreground) * (sum / foreground);
}

void FieldOptimizer::Implementation::update_level(const kernels::AdamStep& step, std::size_t level) {
  const std::size_t at = begin_of(level);
  float* gradient = table.gradient.data() + at;
  float* first = table.first.data() + at;
  float* second = table.second.data() + at;
  if (quantisers.empty()) return kernels::adam(step, size_of(level), field.table.data() + at, gradient, first, second);
  const kernels::QuantisedCopy seen{quantisers[level], field.table.data() + at};
  kernels::adam(step, size_of(level), latent.data() + at, gradient, first, second, &seen);
}

// Of the parameters that a gradient has reached; of all, where none was.
double FieldOptimizer::Implementation::root_mean_square(std::size_t level) const {
  double sum = 0;
  double sum_of_reached = 0;
  std::size_t reached = 0;
  for (std::size_t i = begin_of(level); i < begin_of(level) + size_of(level); ++i) {
    const double square = static_cast<double>(field.table[i]) * static_cast<double>(field.table[i]);
    sum += square;
    if (table.second[i] == 0) continue;
    sum_of_reached += square;
    ++reached;
  }
  return std::sqrt(reached > 0 ? sum_of_reached / static_cast<double>(reached)
                               : sum / static_cast<double>(size_of(level)));
}

FieldOptimizer::FieldOptimizer(Field& field, const LossWeights& weights, float min_gradient)
    : implementation_(std::make_unique<Implementation>(field, weights, min_gradient)) {}
FieldOptimizer::FieldOptimizer(Field& field, const FieldOptimizer& before) {
  const Implementation& old = *before.implementation_;
  implementation_ = std::make_unique<Implementation>(field, old.weights, old.min_gradient);
  Implementation& s = *implementation_;
  s.table.first = with_doubled_rows(old.field.config, old.table.first);
  s.table.second = with_doubled_rows(old.field.config, old.table.second);
  s.density_net = old.density_net;
  s.color_net = old.color_net;
  s.sharpness_moments = old.sharpness_moments;
  s.steps = old.steps;
}
FieldOptimizer::~FieldOptimizer() = default;

void FieldOptimizer::begin_quantisation(const TableQuantisation& quantisation) {
  Implementation& s = *implementation_;
  s.latent = s.field.table;
  s.quantisers.clear();
  for (std::size_t l = 0; l < s.levels.size(); ++l) {
    const bool is_coarse = 2 * l < s.levels.size();
    const double steps = is_coarse ? quantisation.coarse_steps : quantisation.fine_steps;
    const kernels::Quantiser& quantiser = s.quantisers.emplace_back(kernels::Quantiser{
        power_of_two_below(s.root_mean_square(l) / steps), static_cast<float>(quantisation.up_from)});
    const std::size_t at = s.begin_of(l);
    kernels::quantise(quantiser, s.size_of(l), s.latent.data() + at, s.field.table.data() + at);
  }
}

bool FieldOptimizer::is_quantising() const { return !implementation_->quantisers.empty(); }

double FieldOptimizer::table_fill() const {
  const GridLevel& finest = implementation_->levels.back();
  const float* moments = implementation_->table.second.data() + static_cast<std::size_t>(finest.offset) * kF;
  std::size_t reached = 0;
  for (std::size_t e = 0; e < finest.size; ++e) {
    const float* row = moments + e * kF;
    reached += std::any_of(row, row + kF, [](float moment) { return moment > 0; }) ? 1 : 0;
  }
  return static_cast<double>(reached) / finest.size;
}

void FieldOptimizer::draw(const StepRays& rays) {
  implementation_->prepare(rays);
  parallel_for(rays.chunks, 1, [&](const Chunk& c) { implementation_->draw(rays, c.index); });
}

StepResult FieldOptimizer::step(const LearningRates& rates, const StepRays& next) {
  Implementation& s = *implementation_;
  ++s.steps;
  kernels::AdamStep adam_step{};
  const double correction = std::sqrt(1 - std::pow(static_cast<double>(adam_step.beta2), s.steps)) /
                            (1 - std::pow(static_cast<double>(adam_step.beta1), s.steps));
  adam_step.learning_rate = static_cast<float>(rates.table * correction);
  const auto update_level = [&s, adam_step](std::size_t l) { s.update_level(adam_step, l); };
  const StepResult result = s.accumulate(update_level, next);
  adam_step.learning_rate = static_cast<float>(rates.nets * correction);
  if (s.field.config.geometry == Geometry::kSignedDistance) {
    adam_scalar(adam_step, s.sharpness_gradient, s.field.sharpness, s.sharpness_moments);
    s.sharpness_gradient = 0;
  }
  const FlushToZero flush;
  for (auto [parameters, moments] :
       {std::pair(&s.field.density_net, &s.density_net), std::pair(&s.field.color_net, &s.color_net)}) {
    kernels::adam(adam_step, parameters->size(), parameters->data(), moments->gradient.data(), moments->first.data(),
                  moments->second.data());
  }
  return result;
}

StepResult FieldOptimizer::gradient(const StepRays& rays, Gradient& gradient) {
  Implementation& s = *implementation_;
  draw(rays);
  const StepResult result = s.accumulate([](std::size_t) {}, {});
  for (auto [moments, out] : {std::pair(&s.table, &gradient.table), std::pair(&s.density_net, &gradient.density_net),
                              std::pair(&s.color_net, &gradient.color_net)}) {
    out->assign(moments->gradient.begin(), moments->gradient.end());
    std::fill(moments->gradient.begin(), moments->gradient.end(), 0.0F);
  }
  gradient.sharpness = std::exchange(s.sharpness_gradient, 0.0F);
  return result;
}

} // namespace kinora::fields
