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

/// Buffers and results of one chunk of rays; kept from step to step.
struct ChunkWork {
  RayBatch rays;
  std::vector<float> x, y, z;
  PointBatch points;
  ColorBatch color;
  ChunkCompositor compositor;
  std::vector<float> color_gradient, second_gradient, first_gradient, input_gradient;
  std::vector<float> geometry_gradient, hidden_gradient, encoding_gradient;
  std::vector<float> level_gradient; // levels × samples × kFeatures
  std::vector<float> density_net_gradient, color_net_gradient;
  double loss = 0;

  kernels::Points sample_points() const { return {x.data(), y.data(), z.data(), rays.samples.size()}; }
  void gather_coordinates() {
    const std::size_t n = rays.samples.size();
    x.resize(n);
    y.resize(n);
    z.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      x[i] = rays.samples[i].position[0];
      y[i] = rays.samples[i].position[1];
      z[i] = rays.samples[i].position[2];
    }
  }
};

struct Moments {
  std::vector<float> gradient, first, second;
  explicit Moments(std::size_t size) : gradient(size, 0.0F), first(size, 0.0F), second(size, 0.0F) {}
};

void add_to(std::vector<float>& sum, const std::vector<float>& values) {
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += values[i];
}

} // namespace

struct FieldOptimizer::Implementation {
  Field& field;
  LossWeights weights;
  std::vector<GridLevel> levels;
  Moments table, density_net, color_net;
  std::vector<std::vector<std::uint64_t>> touched; // per level, a bit per entry
  std::vector<ChunkWork> work;
  long steps = 0;

  Implementation(Field& f, const LossWeights& w)
      : field(f), weights(w), levels(grid_levels(f.config)), table(f.table.size()), density_net(f.density_net.size()),
        color_net(f.color_net.size()) {
    for (const GridLevel& level : levels) touched.emplace_back((level.size + 63) / 64, 0);
  }

  void forward_backward(ChunkWork& chunk, const TransposedNets& transposed, float scale) const;
  void color_backward(ChunkWork& chunk, const TransposedNets& transposed) const;
  void points_backward(ChunkWork& chunk, const TransposedNets& transposed) const;
  StepResult accumulate(std::size_t chunks, const std::function<void(std::size_t, RayBatch&)>& fill,
                        const std::function<void(std::size_t)>& after_level);
};

void FieldOptimizer::Implementation::color_backward(ChunkWork& chunk, const TransposedNets& transposed) const {
  const std::size_t n = chunk.compositor.own_ray_count();
  chunk.second_gradient.resize(n * kC);
  chunk.first_gradient.resize(n * kC);
  chunk.input_gradient.resize(n * kG);
  float* gradient = chunk.color_net_gradient.data();
  const float* third_t = transposed.color.data();
  const float* second_t = third_t + kC * kO;
  const float* first_t = second_t + kC * kC;
  kernels::accumulate_weight_gradient(chunk.color.second.data(), chunk.color_gradient.data(), n, kC, kO,
                                      gradient + kColorThird);
  kernels::dense(chunk.color_gradient.data(), n, kO, third_t, kC, false, chunk.second_gradient.data());
  kernels::relu_backward(chunk.color.second.data(), n * kC, chunk.second_gradient.data());
  kernels::accumulate_weight_gradient(chunk.color.first.data(), chunk.second_gradient.data(), n, kC, kC,
                                      gradient + kColorSecond);
  kernels::dense(chunk.second_gradient.data(), n, kC, second_t, kC, false, chunk.first_gradient.data());
  kernels::relu_backward(chunk.color.first.data(), n * kC, chunk.first_gradient.data());
  kernels::accumulate_weight_gradient(chunk.color.input.data(), chunk.first_gradient.data(), n, kG, kC,
                                      gradient + kColorFirst);
  kernels::dense(chunk.first_gradient.data(), n, kC, first_t, kG, false, chunk.input_gradient.data());
}

void FieldOptimizer::Implementation::points_backward(ChunkWork& chunk, const TransposedNets& transposed) const {
  const std::size_t n = chunk.rays.samples.size();
  const int width = field.config.encoding_width();
  chunk.hidden_gradient.resize(n * kH);
  chunk.encoding_gradient.resize(n * static_cast<std::size_t>(width));
  chunk.level_gradient.resize(n * static_cast<std::size_t>(width));
  float* gradient = chunk.density_net_gradient.data();
  kernels::accumulate_weight_gradient(chunk.points.hidden.data(), chunk.geometry_gradient.data(), n, kH, kG,
                                      gradient + width * kH);
  kernels::dense(chunk.geometry_gradient.data(), n, kG, transposed.density.data(), kH, false,
                 chunk.hidden_gradient.data());
  kernels::relu_backward(chunk.points.hidden.data(), n * kH, chunk.hidden_gradient.data());
  kernels::accumulate_weight_gradient(chunk.points.encoding.data(), chunk.hidden_gradient.data(), n, width, kH,
                                      gradient);
  kernels::dense(chunk.hidden_gradient.data(), n, kH, transposed.density.data() + kG * kH, width, false,
                 chunk.encoding_gradient.data());
  for (std::size_t l = 0; l < levels.size(); ++l) {
    float* out = chunk.level_gradient.data() + l * n * kF;
    const float* in = chunk.encoding_gradient.data() + l * kF;
    for (std::size_t i = 0; i < n; ++i) std::copy_n(in + i * static_cast<std::size_t>(width), kF, out + i * kF);
  }
}

void FieldOptimizer::Implementation::forward_backward(ChunkWork& chunk, const TransposedNets& transposed,
                                                      float scale) const {
  chunk.gather_coordinates();
  chunk.density_net_gradient.assign(field.density_net.size(), 0.0F);
  chunk.color_net_gradient.assign(field.color_net.size(), 0.0F);
  evaluate_points(field, levels, chunk.sample_points(), chunk.points);
  const float* geometry = chunk.points.geometry.data();
  chunk.compositor.forward(chunk.rays, geometry, weights, chunk.color);
  evaluate_colors(field, chunk.compositor.own_ray_count(), chunk.color);
  chunk.loss = chunk.compositor.loss(chunk.rays, weights, scale, chunk.color, chunk.color_gradient);
  color_backward(chunk, transposed);
  chunk.geometry_gradient.resize(chunk.rays.samples.size() * kG);
  chunk.compositor.backward(chunk.rays, geometry, weights, scale, chunk.color, chunk.input_gradient.data(),
                            chunk.geometry_gradient.data());
  points_backward(chunk, transposed);
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
    opacity += work[c].compositor.own_opacity_sum();
    own += work[c].compositor.own_ray_count();
  }
  result.opacity = own > 0 ? opacity / static_cast<double>(own) : 0.0;

  // The finest levels first: they take longest.
  parallel_for(levels.size(), 1, [&](const Chunk& c) {
    const std::size_t l = levels.size() - 1 - c.index;
    float* gradient = table.gradient.data() + static_cast<std::size_t>(levels[l].offset) * kF;
    for (std::size_t k = 0; k < chunks; ++k) {
      const ChunkWork& chunk = work[k];
      kernels::scatter_level(levels[l], chunk.sample_points(),
                             chunk.level_gradient.data() + l * chunk.rays.samples.size() * kF, gradient,
                             touched[l].data());
    }
    after_level(l);
  });
  return result;
}

FieldOptimizer::FieldOptimizer(Field& field, const LossWeights& weights)
    : implementation_(std::make_unique<Implementation>(field, weights)) {}
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
    kernels::adam_rows(adam, s.touched[l].size(), s.touched[l].data(), s.field.table.data() + at,
                       s.table.gradient.data() + at, s.table.first.data() + at, s.table.second.data() + at);
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
  gradient = {s.table.gradient, s.density_net.gradient, s.color_net.gradient};
  for (Moments* moments : {&s.table, &s.density_net, &s.color_net}) {
    std::fill(moments->gradient.begin(), moments->gradient.end(), 0.0F);
  }
  for (auto& bits : s.touched) std::fill(bits.begin(), bits.end(), 0);
  return result;
}

} // namespace kinora::fields
