// Vectors among the features: they turn with the layer. Where lights stand still a surface that turns among them is lit
// by how its normal lies in the world, which a vector that is fixed to it tells the colour net.
// Source: Deng et al., "Vector Neurons: A General Framework for SO(3)-Equivariant Networks", ICCV 2021.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <Eigen/Geometry>

#include "fields/model/field.h"

namespace kinora::fields {

/// A rotation from canonical space to the world: a unit quaternion x y z w.
using Rotation = std::array<float, 4>;
inline constexpr Rotation kNoRotation{0, 0, 0, 1};
inline Rotation inverse_rotation(const Rotation& rotation) {
  return {rotation[0], rotation[1], rotation[2], -rotation[3]};
}
inline Rotation rotation_of(const Eigen::Matrix3d& rotation) {
  const Eigen::Quaternionf q(rotation.cast<float>());
  return {q.x(), q.y(), q.z(), q.w()};
}

/// Turns the vectors at the beginning of a row of features.
template <class T> inline void rotate_vectors(const Rotation& rotation, T* features) {
  const T x = rotation[0], y = rotation[1], z = rotation[2], w = rotation[3];
  for (int i = 0; i < FieldConfig::kVectors; ++i, features += 3) {
    const T a = features[0], b = features[1], c = features[2];
    const T p = w * a + y * c - z * b, q = w * b + z * a - x * c, r = w * c + x * b - y * a;
    features[0] = a + 2 * (y * r - z * q);
    features[1] = b + 2 * (z * p - x * r);
    features[2] = c + 2 * (x * q - y * p);
  }
}

/// As training keeps one for each pixel: to a ten-thousandth of a radian.
using PackedRotation = std::array<std::int16_t, 4>;
inline PackedRotation packed(const Rotation& rotation) {
  PackedRotation packed{};
  for (std::size_t i = 0; i < 4; ++i) packed[i] = static_cast<std::int16_t>(std::lrint(32767.0F * rotation[i]));
  return packed;
}
inline Rotation unpacked(const PackedRotation& packed) {
  Rotation rotation{};
  for (std::size_t i = 0; i < 4; ++i) rotation[i] = static_cast<float>(packed[i]) / 32767.0F;
  return rotation;
}

} // namespace kinora::fields
