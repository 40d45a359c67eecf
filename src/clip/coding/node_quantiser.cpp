#include "clip/coding/node_quantiser.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include "core/error.h"

namespace kinora::clip {

namespace {

WideQuaternion widened(const std::array<std::int32_t, 4>& q) { return {q[0], q[1], q[2], q[3]}; }

WideQuaternion conjugate(const WideQuaternion& q) { return {q[0], -q[1], -q[2], -q[3]}; }

WideQuaternion product(const WideQuaternion& a, const WideQuaternion& b) {
  return {a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3], a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
          a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1], a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]};
}

// Of one number or two, given their sum; to the nearest, halves up.
std::int64_t mean_of(std::int64_t sum, std::size_t count) { return count == 1 ? sum : (sum + 1) >> 1; }
static_assert(NodePrediction::kMax == 2);

std::int32_t to_units(double metres, double units, std::int32_t farthest) {
  const double scaled = metres * units;
  if (!(std::abs(scaled) <= farthest)) {
    throw Error(
        ErrorCode::kFailure,
        fmt::format("a node of a deformation graph is at {} m, not finite or too far away to be stored", metres));
  }
  return static_cast<std::int32_t>(std::lrint(scaled));
}

} // namespace

std::uint64_t squared_distance(const RestPosition& a, const RestPosition& b) {
  std::uint64_t sum = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t difference = std::int64_t{a[axis]} - b[axis];
    sum += static_cast<std::uint64_t>(difference * difference);
  }
  return sum;
}

RestPosition quantise_rest(const Eigen::Vector3d& canonical) {
  RestPosition rest{};
  for (int a = 0; a < 3; ++a) rest[static_cast<std::size_t>(a)] = to_units(canonical[a], kRestUnits, kFarthestRest);
  return rest;
}

std::vector<RestPosition> quantise_rest(std::span<const Eigen::Vector3d> canonical) {
  std::vector<RestPosition> rest;
  for (const Eigen::Vector3d& position : canonical) rest.push_back(quantise_rest(position));
  return rest;
}

Eigen::Vector3d dequantise(const RestPosition& rest) { return Eigen::Vector3d(rest[0], rest[1], rest[2]) / kRestUnits; }

NodeState quantise(const DualQuaternion& node_to_world, const RestPosition& rest, const NodeSteps& steps) {
  constexpr double kTolerance = 1e-3;
  const Eigen::Quaterniond& q = node_to_world.real;
  if (!(std::abs(q.squaredNorm() - 1) < kTolerance)) {
    throw Error(ErrorCode::kFailure, "the transform of a graph's node is no unit dual quaternion; it cannot be stored");
  }
  NodeState state;
  const Eigen::Vector3d position = node_to_world.to_se3() * dequantise(rest);
  for (int a = 0; a < 3; ++a) {
    state.position[static_cast<std::size_t>(a)] =
        steps.position * to_units(position[a], kLiveUnits / steps.position, kFarthestLive / steps.position);
  }
  const Eigen::Vector4d wxyz(q.w(), q.x(), q.y(), q.z());
  const double scale = kQuaternionUnits / wxyz.cwiseAbs().maxCoeff() / steps.rotation;
  WideQuaternion rounded{};
  for (int c = 0; c < 4; ++c) rounded[static_cast<std::size_t>(c)] = std::lrint(wxyz[c] * scale);
  // q and −q are the same rotation: the largest component is positive.
  const int sign = rounded[largest_component(rounded)] < 0 ? -1 : 1;
  for (std::size_t c = 0; c < 4; ++c) state.rotation[c] = static_cast<std::int32_t>(sign * steps.rotation * rounded[c]);
  return state;
}

DualQuaternion dequantise(const NodeState& state, const RestPosition& rest) {
  const auto& r = state.rotation;
  const Eigen::Quaterniond rotation = Eigen::Quaterniond(r[0], r[1], r[2], r[3]).normalized();
  const Eigen::Vector3d position(state.position[0], state.position[1], state.position[2]);
  return DualQuaternion::from(rotation, position / kLiveUnits - rotation * dequantise(rest));
}

NodePredictor::NodePredictor(std::span<const RestPosition> rest) : rest_(rest.size()), neighbours_(rest.size()) {
  constexpr std::int64_t kRestInLive = 1 << 7;
  for (std::size_t i = 0; i < rest.size(); ++i) {
    for (std::size_t a = 0; a < 3; ++a) {
      rest_[i].position[a] = static_cast<std::int32_t>(rounded_quotient(rest[i][a], kRestInLive));
    }
  }
  choose_order(rest);
}

void NodePredictor::Neighbours::offer(std::uint32_t node, std::uint64_t squared_distance) {
  if (count == nodes.size() && squared_distance >= squared_distances.back()) return;
  std::size_t at = count < nodes.size() ? count++ : count - 1;
  for (; at > 0 && squared_distance < squared_distances[at - 1]; --at) {
    squared_distances[at] = squared_distances[at - 1];
    nodes[at] = nodes[at - 1];
  }
  squared_distances[at] = squared_distance;
  nodes[at] = node;
}

// Prim's: from node 0 on, always the node that is nearest to any that has been taken; of equally near ones the first.
void NodePredictor::choose_order(std::span<const RestPosition> rest) {
  std::vector<std::uint32_t> left(rest.size());
  std::iota(left.begin(), left.end(), 0U);
  while (!left.empty()) {
    const auto nearer = [this](std::uint32_t a, std::uint32_t b) {
      return neighbours_[a].squared_distances[0] < neighbours_[b].squared_distances[0];
    };
    const auto next = std::min_element(left.begin(), left.end(), nearer);
    const std::uint32_t taken = *next;
    left.erase(next);
    order_.push_back(taken);
    for (const std::uint32_t i : left) neighbours_[i].offer(taken, squared_distance(rest[i], rest[taken]));
  }
}

std::int32_t NodePrediction::component(std::size_t face, std::size_t c) const {
  std::int64_t sum = 0;
  for (std::size_t k = 0; k < count; ++k) {
    if (rotations[k][face] == 0) continue;
    const std::int64_t projected = rounded_quotient(rotations[k][c] * kQuaternionUnits, rotations[k][face]);
    sum += std::clamp<std::int64_t>(projected, -kQuaternionUnits, kQuaternionUnits);
  }
  return static_cast<std::int32_t>(mean_of(sum, count));
}

NodeTurn::NodeTurn(const NodeState& before, const NodeState& after)
    : rotation(product(widened(after.rotation), conjugate(widened(before.rotation)))) {
  WideQuaternion q = rotation;
  for (std::int64_t& component : q) component = rounded_quotient(component, 1 << 9); // now |q| ≤ 2¹⁵
  const auto& [w, x, y, z] = q;
  matrix = {w * w + x * x - y * y - z * z, 2 * (x * y - w * z),           2 * (x * z + w * y),
            2 * (x * y + w * z),           w * w - x * x + y * y - z * z, 2 * (y * z - w * x),
            2 * (x * z - w * y),           2 * (y * z + w * x),           w * w - x * x - y * y + z * z};
  scale = w * w + x * x + y * y + z * z;
}

NodePrediction NodePredictor::predict(std::size_t i, std::span<const NodeState> reference,
                                      std::span<const NodeState> now, std::span<const NodeTurn> turns) const {
  const NodeState& reference_node = reference[i];
  const Neighbours& near = neighbours_[i];
  if (near.count == 0) return {reference_node.position, 1, {widened(reference_node.rotation)}};
  NodePrediction prediction;
  prediction.count = near.count;
  std::array<std::int64_t, 3> sum{};
  for (std::size_t k = 0; k < near.count; ++k) {
    const NodeState& before = reference[near.nodes[k]];
    const NodeState& after = now[near.nodes[k]];
    const NodeTurn& turn = turns[near.nodes[k]];
    prediction.rotations[k] = product(turn.rotation, widened(reference_node.rotation));
    std::array<std::int64_t, 3> arm{}; // no longer than 2²⁹ for each axis
    for (std::size_t a = 0; a < 3; ++a) arm[a] = std::int64_t{reference_node.position[a]} - before.position[a];
    for (std::size_t a = 0; a < 3; ++a) {
      const std::span row = std::span(turn.matrix).subspan(3 * a, 3);
      const std::int64_t turned = row[0] * arm[0] + row[1] * arm[1] + row[2] * arm[2];
      sum[a] += after.position[a] + rounded_quotient(turned, turn.scale);
    }
  }
  for (std::size_t a = 0; a < 3; ++a) {
    const std::int64_t mean = mean_of(sum[a], near.count);
    prediction.position[a] = static_cast<std::int32_t>(std::clamp<std::int64_t>(mean, -kFarthestLive, kFarthestLive));
  }
  return prediction;
}

} // namespace kinora::clip
