#include "fields/optimizer.h"

#include <cmath>

#include "core/parallel.h"
#include "fields/compositing.h"
#include "fields/field_batch.h"

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
  std::size_t mattering = 0;
  std::vector<float> encoding_gradient; // of the samples that matter
  std::vector<float> density_net_gradient, color_net_gradient;
  double loss = 0;
  double own_opacity = 0;
  std::size_t own_rays = 0;

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
  PointBatch points;
  ColorBatch color;
  ChunkCompositor compositor;
  std::vector<float> color_gradient, second_gradient, first_gradient, input_gradient;
  std::vector<float> geometry_gradient, hidden_gradient;
  std::vector<std::uint32_t> mattering;
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

} // namespace

struct FieldOptimizer::Implementation {
  Field& field;
  LossWeights weights;
  float negligible;
  std::vector<GridLevel> levels;
  Moments table, density_net, color_net;
  std::vector<ChunkWork> work;
  long steps = 0;

  Implementation(Field& f, const LossWeights& w, float n)
      : field(f), weights(w), negligible(n), levels(grid_levels(f.config)), table(f.table.size()),
        density_net(f.density_net.size()), color_net(f.color_net.size()) {}

  void forward_backward(ChunkWork& chunk, const TransposedNets& transposed, float scale) const;
  void color_backward(ChunkWork& chunk, Scratch& scratch, const TransposedNets& transposed) const;
  void keep_mattering(ChunkWork& chunk, Scratch& scratch, float scale) const;
  void points_backward(ChunkWork& chunk, Scratch& scratch, const TransposedNets& transposed) const;
  StepResult accumulate(std::size_t chunks, const std::function<void(std::size_t, RayBatch&)>& fill,
                        const std::function<void(std::size_t)>& after_level);
};

void FieldOptimizer::Implementation::color_backward(ChunkWork& chunk, Scratch& scratch,
                                                    const TransposedNets& transposed) const {
  const std::size_t n = scratch.compositor.own_ray_count();
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

void FieldOptimizer::Implementation::keep_mattering(ChunkWork& chunk, Scratch& scratch, float scale) const {
  const std::size_t n = chunk.rays.samples.size();
  chunk.mattering = n;
  if (negligible <= 0) return;
  scratch.mattering.resize(n);
  chunk.mattering =
      kernels::rows_above(scratch.geometry_gradient.data(), n, negligible * scale, scratch.mattering.data());
  for (std::size_t to = 0; to < chunk.mattering; ++to) {
    const std::size_t from = scratch.mattering[to];
    if (from == to) continue;
    chunk.x[to] = chunk.x[from];
    chunk.y[to] = chunk.y[from];
    chunk.z[to] = chunk.z[from];
    move_row(scratch.points.encoding, from, to, levels.size() * kF);
    move_row(scratch.points.hidden, from, to, kH);
    move_row(scratch.geometry_gradient, from, to, kG);
  }
}

void FieldOptimizer::Implementation::points_backward(ChunkWork& chunk, Scratch& scratch,
                                                     const TransposedNets& transposed) const {
  const std::size_t n = chunk.mattering;
  const int width = field.config.encoding_width();
  scratch.hidden_gradient.resize(n * kH);
  chunk.encoding_gradient.resize(n * static_cast<std::size_t>(width));
  float* gradient = chunk.density_net_gradient.data();
  kernels::accumulate_weight_gradient(scratch.points.hidden.data(), scratch.geometry_gradient.data(), n, kH, kG,
                                      gradient + width * kH);
  kernels::dense(scratch.geometry_gradient.data(), n, kG, transposed.density.data(), kH, false,
                 scratch.hidden_gradient.data());
  kernels::relu_backward(scratch.points.hidden.data(), n * kH, scratch.hidden_gradient.data());
  kernels::accumulate_weight_gradient(scratch.points.encoding.data(), scratch.hidden_gradient.data(), n, width, kH,
                                      gradient);
  kernels::dense(scratch.hidden_gradient.data(), n, kH, transposed.density.data() + kG * kH, width, false,
                 chunk.encoding_gradient.data());
}

void FieldOptimizer::Implementation::forward_backward(ChunkWork& chunk, const TransposedNets& transposed,
                                                      float scale) const {
  static thread_local Scratch scratch;
  chunk.gather_samples();
  chunk.density_net_gradient.assign(field.density_net.size(), 0.0F);
  chunk.color_net_gradient.assign(field.color_net.size(), 0.0F);
  evaluate_points(field, levels, chunk.points(chunk.rays.samples.size()), scratch.points);
  const float* geometry = scratch.points.geometry.data();
  scratch.compositor.forward(chunk.rays, chunk.length, geometry, weights, scratch.color);
  evaluate_colors(field, scratch.compositor.own_ray_count(), scratch.color);
  chunk.loss = scratch.compositor.loss(chunk.rays, weights, scale, scratch.color, scratch.color_gradient);
  chunk.own_opacity = scratch.compositor.own_opacity_sum();
  chunk.own_rays = scratch.compositor.own_ray_count();
  color_backward(chunk, scratch, transposed);
  scratch.geometry_gradient.resize(chunk.rays.samples.size() * kG);
  scratch.compositor.backward(chunk.rays, geometry, weights, scale, scratch.color, scratch.input_gradient.data(),
                              scratch.geometry_gradient.data());
  keep_mattering(chunk, scratch, scale);
  points_backward(chunk, scratch, transposed);
}

StepResult FieldOptimizer::Implementation::accumulate(std::size_t chunks,
                                                      const std::function<void(std::size_t, RayBatch&)>& fill,
                                                      const std::function<void(std::size_t)>& after_level) {
  if (work.size() < chunks) work.resize(chunks);
  parallel_for(chunks, 1, [&](const Chunk& c) {
    work[c.index].rays.clear();
    fill(c.index, work[c.index].rays);
  });
  std::size_t rays = 0;
  for (std::size_t c = 0; c < chunks; ++c) rays += work[c].rays.ray_count();
  if (rays == 0) return {};

  const TransposedNets transposed(field);
  const float scale = 1.0F / static_cast<float>(rays);
  parallel_for(chunks, 1, [&](const Chunk& c) { forward_backward(work[c.index], transposed, scale); });

  StepResult result;
  double opacity = 0;
  std::size_t own = 0;
  for (std::size_t c = 0; c < chunks; ++c) {
    add_to(density_net.gradient, work[c].density_net_gradient);
    add_to(color_net.gradient, work[c].color_net_gradient);
    result.loss += work[c].loss / static_cast<double>(rays);
    result.samples += work[c].rays.samples.size();
    opacity += work[c].own_opacity;
    own += work[c].own_rays;
  }
  result.opacity = own > 0 ? opacity / static_cast<double>(own) : 0.0;

  // The finest levels first: they take longest.
  parallel_for(levels.size(), 1, [&](const Chunk& c) {
    const std::size_t l = levels.size() - 1 - c.index;
    float* gradient = table.gradient.data() + static_cast<std::size_t>(levels[l].offset) * kF;
    for (std::size_t k = 0; k < chunks; ++k) {
      const ChunkWork& chunk = work[k];
      kernels::scatter_level(levels[l], chunk.points(chunk.mattering), chunk.encoding_gradient.data() + l * kF,
                             levels.size() * kF, gradient);
    }
    after_level(l);
  });
  return result;
}

FieldOptimizer::FieldOptimizer(Field& field, const LossWeights& weights, float negligible)
    : implementation_(std::make_unique<Implementation>(field, weights, negligible)) {}
FieldOptimizer::~FieldOptimizer() = default;

StepResult FieldOptimizer::step(std::size_t chunks, const std::function<void(std::size_t, RayBatch&)>& fill,
                                const LearningRates& rates) {
  Implementation& s = *implementation_;
  ++s.steps;
  kernels::AdamStep adam{};
  const double correction = std::sqrt(1 - std::pow(static_cast<double>(adam.beta2), s.steps)) /
                            (1 - std::pow(static_cast<double>(adam.beta1), s.steps));
  adam.learning_rate = static_cast<float>(rates.table * correction);
  const StepResult result = s.accumulate(chunks, fill, [&](std::size_t l) {
    const std::size_t at = static_cast<std::size_t>(s.levels[l].offset) * kF;
    kernels::adam_rows(adam, s.levels[l].size, s.field.table.data() + at, s.table.gradient.data() + at,
                       s.table.first.data() + at, s.table.second.data() + at);
  });
  adam.learning_rate = static_cast<float>(rates.nets * correction);
  for (auto [parameters, moments] :
       {std::pair(&s.field.density_net, &s.density_net), std::pair(&s.field.color_net, &s.color_net)}) {
    kernels::adam_all(adam, parameters->size(), parameters->data(), moments->gradient.data(), moments->first.data(),
                      moments->second.data());
  }
  return result;
}

StepResult FieldOptimizer::gradient(std::size_t chunks, const std::function<void(std::size_t, RayBatch&)>& fill,
                                    Gradient& gradient) {
  Implementation& s = *implementation_;
  const StepResult result = s.accumulate(chunks, fill, [](std::size_t) {});
  for (auto [moments, out] : {std::pair(&s.table, &gradient.table), std::pair(&s.density_net, &gradient.density_net),
                              std::pair(&s.color_net, &gradient.color_net)}) {
    out->assign(moments->gradient.begin(), moments->gradient.end());
    std::fill(moments->gradient.begin(), moments->gradient.end(), 0.0F);
  }
  return result;
}

} // namespace kinora::fields
