// The field's mathematics, written once and plainly, for any scalar type: the specification that every backend is
// tested against, and whose gradients are checked numerically in double.
//
// A point: hash-grid encoding e (Müller et al. 2022, sec. 3), h = relu(eᵀ W₁), g = hᵀ W₂; g₀ is the raw density, or a
// signed distance with g₀ = ln(Ψ(−exp(k) s)) + k its raw density (volume_density.h; Ψ of Laplace's distribution, k the
// sharpness); σ = exp(min(g₀, kMaxRawDensity)); g₁…g₁₅ are features. A ray (Max 1995; Mildenhall et al. 2020): αᵢ = 1 −
// exp(−σᵢ δᵢ), wᵢ = αᵢ Πⱼ<ᵢ (1 − αⱼ), A = Σ wᵢ, F = Σ wᵢ gᵢ; colour = sigmoid(MLP([R F / (A + ε), 1])), where R turns
// the vectors among the features as the layer is turned (vector_features.h).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "fields/model/field.h"
#include "fields/model/grid_vertex.h"
#include "fields/network/vector_features.h"
#include "fields/network/volume_density.h"

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

} // namespace kinora::fields::reference
