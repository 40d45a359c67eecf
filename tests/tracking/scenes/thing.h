// Things that people handle, as analytic surfaces with colours.
#pragma once

#include <functional>

#include <Eigen/Core>

namespace kinora::tracking::testing {

/// A thing in its own space, about the origin.
struct Thing {
  double reach = 0;                                              ///< metres: all of it lies so near the origin
  std::function<double(const Eigen::Vector3d&)> distance;        ///< signed, at most that to the surface
  std::function<Eigen::Vector3d(const Eigen::Vector3d&)> colour; ///< reflectance of red, green and blue
  double gloss = 0;                                              ///< of a highlight that stays where the light is

  Eigen::Vector3d normal(const Eigen::Vector3d& position) const;
};

/// 26 cm high about y, 18 cm wide, with one small handle towards x. Its print is drawn all about it.
Thing vase(bool printed);
/// A head of 14 cm along x at y = 0.10 and a handle of 34 cm along y.
Thing mallet();
Thing ball(double radius, bool striped);
/// A box of these half sides with a print that differs by seed.
Thing printed_box(const Eigen::Vector3d& half, std::uint64_t seed);
/// Of one colour.
Thing plain_box(const Eigen::Vector3d& half, const Eigen::Vector3d& colour);

} // namespace kinora::tracking::testing
