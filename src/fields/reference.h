// The field's mathematics, written once and plainly, for any scalar type: the specification that every backend is
// tested against, and whose gradients are checked numerically in double.
//
// A point: hash-grid encoding e (Müller et al. 2022, sec. 3), h = relu(eᵀ W₁), g = hᵀ W₂; g₀ is the raw density, or a
// signed distance with g₀ = ln(Ψ(−exp(k) s)) + k its raw density (signed_distance.h; Ψ of Laplace's distribution, k the
// sharpness); σ = exp(min(g₀, kMaxRawDensity)); g₁…g₁₅ are features. A ray (Max 1995; Mildenhall et al. 2020): αᵢ = 1 −
// exp(−σᵢ δᵢ), wᵢ = αᵢ Πⱼ<ᵢ (1 − αⱼ), A = Σ wᵢ, F = Σ wᵢ gᵢ; colour = sigmoid(MLP([R F / (A + ε), 1])), where R turns
// the vectors among the features as the layer is turned (turn.h).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "fields/field.h"
#include "fields/ray_batch.h"

namespace kinora::fields::reference {

template <class T> struct Parameters {
  std::vector<T> table, density_net, color_net;
  T sharpness = 0;

  Parameters() = default;
  explicit Parameters(const Field& field)
      : table(field.table.begin(), field.table.end()), density_net(field.density_net.begin(), field.density_net.end()),
        color_net(field.color_net.begin(), field.color_net.end()), sharpness(field.sharpness) {}
  Parameters zeros() const {
    Parameters p;
    p.table.assign(table.size(), T(0));
    p.density_net.assign(density_net.size(), T(0));
    p.color_net.assign(color_net.size(), T(0));
    return p;
  }
};

/// Entry of vertex (x, y, z) within its level.
inline std::uint32_t vertex_entry(const GridLevel& level, std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  if (level.hashed) return (x ^ (y * 2654435761U) ^ (z * 805459861U)) & (level.size - 1);
  const std::uint32_t n = static_cast<std::uint32_t>(level.resolution) + 1;
  return (z * n + y) * n + x;
}

/// Calls visit(entry of the whole table, trilinear weight) for the eight corners around a position.
template <class T, class Visit>
void for_each_corner(const GridLevel& level, const std::array<T, 3>& position, const Visit& visit) {
  std::array<std::uint32_t, 3> cell{};
  std::array<T, 3> fraction{};
  for (int a = 0; a < 3; ++a) {
    const T scaled = std::clamp(position[a], T(0), T(1)) * T(level.resolution);
    cell[a] = std::min(static_cast<std::uint32_t>(scaled), static_cast<std::uint32_t>(level.resolution - 1));
    fraction[a] = scaled - T(cell[a]);
  }
  for (std::uint32_t corner = 0; corner < 8; ++corner) {
    const std::uint32_t dx = corner & 1, dy = (corner >> 1) & 1, dz = corner >> 2;
    const T weight = (dx ? fraction[0] : T(1) - fraction[0]) * (dy ? fraction[1] : T(1) - fraction[1]) *
                     (dz ? fraction[2] : T(1) - fraction[2]);
    visit(level.offset + vertex_entry(level, cell[0] + dx, cell[1] + dy, cell[2] + dz), weight);
  }
}

template <class T>
void encode(std::span<const GridLevel> levels, const std::vector<T>& table, const std::array<T, 3>& position,
            std::span<T> encoding) {
  std::fill(encoding.begin(), encoding.end(), T(0));
  for (std::size_t l = 0; l < levels.size(); ++l) {
    T* out = encoding.data() + l * FieldConfig::kFeatures;
    for_each_corner(levels[l], position, [&](std::size_t entry, T weight) {
      for (int f = 0; f < FieldConfig::kFeatures; ++f) out[f] += weight * table[entry * FieldConfig::kFeatures + f];
    });
  }
}

template <class T>
void encode_backward(std::span<const GridLevel> levels, const std::array<T, 3>& position,
                     std::span<const T> encoding_gradient, std::vector<T>& table_gradient) {
  for (std::size_t l = 0; l < levels.size(); ++l) {
    const T* in = encoding_gradient.data() + l * FieldConfig::kFeatures;
    for_each_corner(levels[l], position, [&](std::size_t entry, T weight) {
      for (int f = 0; f < FieldConfig::kFeatures; ++f) {
        table_gradient[entry * FieldConfig::kFeatures + f] += weight * in[f];
      }
    });
  }
}

/// out = inᵀ W, with W stored inputs × outputs.
template <class T> void dense(std::span<const T> in, const T* weights, std::span<T> out) {
  std::fill(out.begin(), out.end(), T(0));
  for (std::size_t i = 0; i < in.size(); ++i) {
    for (std::size_t o = 0; o < out.size(); ++o) out[o] += in[i] * weights[i * out.size() + o];
  }
}

template <class T>
void dense_backward(std::span<const T> in, const T* weights, std::span<const T> out_gradient, std::span<T> in_gradient,
                    T* weight_gradient) {
  for (std::size_t i = 0; i < in.size(); ++i) {
    T sum = 0;
    for (std::size_t o = 0; o < out_gradient.size(); ++o) {
      sum += weights[i * out_gradient.size() + o] * out_gradient[o];
      weight_gradient[i * out_gradient.size() + o] += in[i] * out_gradient[o];
    }
    in_gradient[i] = sum;
  }
}

template <class T> void relu(std::span<T> values) {
  for (T& v : values) v = std::max(v, T(0));
}
template <class T> void relu_backward(std::span<const T> activated, std::span<T> gradient) {
  for (std::size_t i = 0; i < gradient.size(); ++i) {
    if (!(activated[i] > T(0))) gradient[i] = T(0);
  }
}

/// Raw density of a signed distance, and its derivatives.
template <class T> struct RawDensity { T value, by_distance, by_sharpness; };
template <class T> RawDensity<T> raw_density(T distance, T sharpness) {
  const T rate = std::exp(sharpness);
  const T u = rate * distance;
  const T tail = std::exp(-std::abs(u)) / 2;
  const T fall = u >= 0 ? T(1) : tail / (1 - tail); // −∂ ln Ψ(−u) / ∂u
  return {sharpness + (u >= 0 ? -u - std::log(T(2)) : std::log1p(-tail)), -rate * fall, 1 - u * fall};
}

template <class T> T density(T raw) { return std::exp(std::min(raw, T(kMaxRawDensity))); }

using std::array;
inline constexpr int kG = FieldConfig::kGeometry;
inline constexpr int kH = FieldConfig::kHidden;
inline constexpr int kC = FieldConfig::kColorHidden;
inline constexpr int kO = FieldConfig::kColorOutputs;

/// Everything a point's backward pass needs.
template <class T> struct PointState {
  std::vector<T> encoding;
  array<T, kH> hidden{};
  array<T, kG> geometry{}; ///< raw density, then 15 features
  T distance = 0;          ///< of a field of signed distances, like the next two
  T by_distance = 1;       ///< ∂ raw density
  T by_sharpness = 0;
};

template <class T>
PointState<T> evaluate_point(const FieldConfig& config, std::span<const GridLevel> levels, const Parameters<T>& p,
                             const array<T, 3>& position) {
  PointState<T> s;
  s.encoding.resize(static_cast<std::size_t>(config.encoding_width()));
  encode<T>(levels, p.table, position, s.encoding);
  dense<T>(s.encoding, p.density_net.data(), s.hidden);
  relu<T>(s.hidden);
  dense<T>(s.hidden, p.density_net.data() + config.encoding_width() * kH, s.geometry);
  if (config.geometry == Geometry::kSignedDistance) {
    s.distance = s.geometry[0];
    const RawDensity<T> raw = raw_density(s.distance, p.sharpness);
    s.geometry[0] = raw.value;
    s.by_distance = raw.by_distance;
    s.by_sharpness = raw.by_sharpness;
  }
  return s;
}

template <class T>
void point_backward(const FieldConfig& config, std::span<const GridLevel> levels, const Parameters<T>& p,
                    const array<T, 3>& position, const PointState<T>& s, const array<T, kG>& geometry_gradient,
                    Parameters<T>& gradient) {
  array<T, kH> hidden_gradient{};
  std::vector<T> encoding_gradient(s.encoding.size());
  const auto second = static_cast<std::size_t>(config.encoding_width()) * kH;
  dense_backward<T>(s.hidden, p.density_net.data() + second, geometry_gradient, hidden_gradient,
                    gradient.density_net.data() + second);
  relu_backward<T>(s.hidden, hidden_gradient);
  dense_backward<T>(s.encoding, p.density_net.data(), hidden_gradient, encoding_gradient, gradient.density_net.data());
  encode_backward<T>(levels, position, encoding_gradient, gradient.table);
}

/// The colour MLP; the input's last element is the constant 1.
template <class T> struct ColorState {
  array<T, kG> input{};
  array<T, kC> first{}, second{};
  array<T, 3> color{};
};

template <class T> ColorState<T> evaluate_color(const std::vector<T>& net, const array<T, kG>& input) {
  ColorState<T> s;
  s.input = input;
  array<T, kO> out{};
  dense<T>(s.input, net.data(), s.first);
  relu<T>(s.first);
  dense<T>(s.first, net.data() + kG * kC, s.second);
  relu<T>(s.second);
  dense<T>(s.second, net.data() + kG * kC + kC * kC, out);
  for (int c = 0; c < 3; ++c) s.color[c] = T(1) / (T(1) + std::exp(-out[c]));
  return s;
}

template <class T>
array<T, kG> color_backward(const std::vector<T>& net, const ColorState<T>& s, const array<T, 3>& color_gradient,
                            std::vector<T>& net_gradient) {
  array<T, kO> out_gradient{};
  array<T, kC> second_gradient{}, first_gradient{};
  array<T, kG> input_gradient{};
  for (int c = 0; c < 3; ++c) out_gradient[c] = color_gradient[c] * s.color[c] * (T(1) - s.color[c]);
  dense_backward<T>(s.second, net.data() + kG * kC + kC * kC, out_gradient, second_gradient,
                    net_gradient.data() + kG * kC + kC * kC);
  relu_backward<T>(s.second, second_gradient);
  dense_backward<T>(s.first, net.data() + kG * kC, second_gradient, first_gradient, net_gradient.data() + kG * kC);
  relu_backward<T>(s.first, first_gradient);
  dense_backward<T>(s.input, net.data(), first_gradient, input_gradient, net_gradient.data());
  return input_gradient;
}

/// How far, in bands, a sample's distance is from what the depth measured on its ray implies, and the derivative. Zero
/// outside of the band.
template <class T> struct DistanceResidual { T value = 0, by_distance = 0; };
template <class T> DistanceResidual<T> distance_residual(T distance, const RaySample& sample, const RayTarget& target) {
  if (!target.own || !(target.depth > 0)) return {};
  const T measured = (T(target.depth) - T(sample.depth)) * T(target.inverse_band);
  if (std::abs(measured) > T(1)) return {};
  const T per_distance = T(target.inverse_band) / T(target.lengths_per_depth);
  return {distance * per_distance - measured, per_distance};
}

/// Loss of one ray (see LossWeights); adds scale · its gradient to `gradient` if that is given.
template <class T>
T ray_loss(const FieldConfig& config, std::span<const GridLevel> levels, const Parameters<T>& p,
           std::span<const RaySample> samples, const RayTarget& target, const LossWeights& weights, T scale,
           Parameters<T>* gradient) {
  const std::size_t n = samples.size();
  std::vector<array<T, 3>> positions(n);
  std::vector<PointState<T>> points(n);
  std::vector<T> weight(n), transmittance(n + 1, T(1)), depth_term(n, T(0));
  array<T, kG> features{};
  T opacity = 0;
  for (std::size_t i = 0; i < n; ++i) {
    for (int a = 0; a < 3; ++a) positions[i][a] = T(samples[i].position[a]);
    points[i] = evaluate_point<T>(config, levels, p, positions[i]);
    transmittance[i + 1] = transmittance[i] * std::exp(-density(points[i].geometry[0]) * T(samples[i].length));
    weight[i] = transmittance[i] - transmittance[i + 1];
    opacity += weight[i];
    for (int f = 1; f < kG; ++f) features[f - 1] += weight[i] * points[i].geometry[f];
    if (target.own && target.depth > 0) {
      const T residual = (T(samples[i].depth) - T(target.depth)) * T(target.inverse_band);
      depth_term[i] = std::min(residual * residual, T(weights.depth_clamp));
    }
  }

  const bool has_distances = config.geometry == Geometry::kSignedDistance;
  T loss = 0;
  T opacity_gradient = 0;
  array<T, kG> feature_gradient{};
  if (target.own) {
    const T normaliser = T(1) / (opacity + T(kOpacityEpsilon));
    array<T, kG> input{};
    for (int f = 0; f < kG - 1; ++f) input[f] = features[f] * normaliser;
    input[kG - 1] = T(1);
    array<T, kG> turned = input;
    turn_vectors(target.turn, turned.data());
    const ColorState<T> color = evaluate_color<T>(p.color_net, turned);
    array<T, 3> color_gradient{};
    for (int c = 0; c < 3; ++c) {
      const T difference = color.color[c] - T(target.color[c]);
      loss += T(weights.color) * difference * difference;
      color_gradient[c] = scale * T(2) * T(weights.color) * difference;
    }
    loss += T(weights.opacity) * (T(1) - opacity) * (T(1) - opacity);
    for (std::size_t i = 0; i < n; ++i) {
      loss += T(weights.depth) * weight[i] * depth_term[i];
      if (!has_distances) continue;
      const T residual = distance_residual(points[i].distance, samples[i], target).value;
      loss += T(weights.distance) * residual * residual;
    }
    if (gradient) {
      array<T, kG> input_gradient = color_backward<T>(p.color_net, color, color_gradient, gradient->color_net);
      turn_vectors(turned_back(target.turn), input_gradient.data());
      opacity_gradient = -scale * T(2) * T(weights.opacity) * (T(1) - opacity);
      for (int f = 0; f < kG - 1; ++f) {
        feature_gradient[f] = input_gradient[f] * normaliser;
        opacity_gradient -= feature_gradient[f] * input[f];
      }
    }
  } else {
    loss = T(weights.emptiness) * opacity;
    opacity_gradient = scale * T(weights.emptiness);
  }
  if (!gradient) return loss;

  T behind = 0; // Σⱼ>ᵢ wⱼ ∂L/∂wⱼ
  for (std::size_t i = n; i-- > 0;) {
    const auto& g = points[i].geometry;
    T weight_gradient = opacity_gradient + scale * T(weights.depth) * depth_term[i];
    array<T, kG> geometry_gradient{};
    for (int f = 1; f < kG; ++f) {
      weight_gradient += feature_gradient[f - 1] * g[f];
      geometry_gradient[f] = weight[i] * feature_gradient[f - 1];
    }
    const T density_gradient = T(samples[i].length) * (transmittance[i + 1] * weight_gradient - behind);
    const T raw_gradient = density_gradient * density(g[0]);
    geometry_gradient[0] = raw_gradient * points[i].by_distance;
    gradient->sharpness += raw_gradient * points[i].by_sharpness;
    if (has_distances) {
      const auto residual = distance_residual(points[i].distance, samples[i], target);
      geometry_gradient[0] += scale * 2 * T(weights.distance) * residual.value * residual.by_distance;
    }
    behind += weight[i] * weight_gradient;
    point_backward<T>(config, levels, p, positions[i], points[i], geometry_gradient, *gradient);
  }
  return loss;
}

} // namespace kinora::fields::reference
