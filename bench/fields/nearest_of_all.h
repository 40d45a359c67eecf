// The search that the look-up tables are measured against: every node is looked at.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace kinora::bench {

/// Nodes in lanes, as wide as the processor has them; padded with nodes that are infinitely far.
class NearestOfAll {
public:
  explicit NearestOfAll(const std::vector<Eigen::Vector3d>& nodes);

  static constexpr std::size_t kFound = 5;
  struct Found {
    std::array<int, kFound> nodes; ///< nearest first; −1: there are fewer
    std::array<float, kFound> squared_distances;
  };
  Found find(const Eigen::Vector3d& point) const;

private:
  Eigen::Vector3d origin_; ///< of the single-precision coordinates
  std::vector<float> x_, y_, z_;
};

} // namespace kinora::bench
