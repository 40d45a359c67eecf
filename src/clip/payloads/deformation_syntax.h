// The syntax of a deformation's nodes, for writer and reader. docs/container.md specifies it.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>
#include <span>

#include "clip/coding/node_quantiser.h"
#include "clip/coding/range_coder.h"

namespace kinora::clip {

/// One for each number of a node that is coded: position x, y, z, then three components of the rotation.
template <class T> using PerNumber = std::array<T, 6>;

/// Sizes of the differences to what was expected of a node, in steps of kCoarseSteps, in one byte each: larger ones
/// than kMost are in no other class.
class NodeSurprise {
public:
  static constexpr std::size_t kClasses = 6; ///< none, 1, 2–3, 4–7, 8–15, more

  void set(std::size_t number, std::uint32_t size) { sizes_ |= std::uint64_t{std::min(size, kMost)} << (8 * number); }
  /// For each number; of at most 15 nodes in all.
  void add(const NodeSurprise& other) { sizes_ += other.sizes_; }
  std::size_t size_class(std::size_t number) const {
    const auto size = static_cast<std::uint8_t>(sizes_ >> (8 * number));
    return std::min<std::size_t>(kClasses - 1, std::bit_width(size));
  }

private:
  static constexpr std::uint32_t kMost = 1U << (kClasses - 2);
  std::uint64_t sizes_ = 0;
};

/// What has been learnt about the differences since the last key payload.
struct DeformationModels {
  static constexpr std::size_t kActivities = NodeSurprise::kClasses; ///< of coarse nodes
  static constexpr std::size_t kFine = kActivities;
  PerNumber<std::array<IntegerModel, kActivities + 1>> difference;
  BitModel fine;
  BitModel same_face;
  std::array<BitModel, 3> face;
};

/// How large the differences were around a node: those of its neighbours, and its own in the payload before.
inline NodeSurprise activity_around(std::span<const std::uint32_t> neighbours, std::size_t node,
                                    std::span<const NodeSurprise> surprises) {
  NodeSurprise activity = surprises[node];
  for (const std::uint32_t neighbour : neighbours) activity.add(surprises[neighbour]);
  return activity;
}

/// One node's syntax. Coders are RangeEncoder and RangeDecoder.
template <class Coder> class NodeSyntax {
public:
  /// `all_fine`: version 1, which knows neither steps nor activities.
  NodeSyntax(Coder& coder, DeformationModels& models, bool all_fine)
      : coder_(coder), models_(models), all_fine_(all_fine) {}

  /// Writes or reads `node`.
  NodeSurprise code(const NodePrediction& prediction, const NodeSurprise& activity, NodeState& node) {
    const bool fine = all_fine_ || coder_.code(models_.fine, !is_multiple_of(node, kCoarseSteps));
    const NodeSteps& steps = fine ? kFineSteps : kCoarseSteps;
    const auto model = [&](std::size_t n) -> IntegerModel& {
      return models_.difference[n][all_fine_ ? 0 : fine ? DeformationModels::kFine : activity.size_class(n)];
    };
    NodeSurprise surprise{};
    for (std::size_t a = 0; a < 3; ++a) {
      const std::uint32_t size = number(model(a), prediction.position[a], steps.position, node.position[a]);
      surprise.set(a, size / static_cast<std::uint32_t>(kCoarseSteps.position / steps.position));
    }
    const std::size_t face = code_face(prediction.face(), largest_component(node.rotation));
    node.rotation[face] = kQuaternionUnits;
    for (std::size_t c = 0, n = 3; c < 4; ++c) {
      if (c == face) continue;
      const std::uint32_t size = number(model(n), prediction.component(face, c), steps.rotation, node.rotation[c]);
      surprise.set(n++, size / static_cast<std::uint32_t>(kCoarseSteps.rotation / steps.rotation));
    }
    return surprise;
  }

private:
  // Writes or reads `value` as its difference to a prediction, in steps; returns the difference's size. What an enemy
  // makes too large stays too large: whoever asked refuses it.
  std::uint32_t number(IntegerModel& model, std::int32_t prediction, std::int32_t step, std::int32_t& value) {
    constexpr std::int64_t kTooLarge = std::int64_t{1} << 30;
    const int halvings = std::countr_zero(static_cast<std::uint32_t>(step));
    const std::int64_t expected = (std::int64_t{prediction} + step / 2) >> halvings;
    const auto wanted = static_cast<std::int32_t>((value >> halvings) - expected);
    const std::int32_t difference = code_integer(coder_, model, wanted);
    value = static_cast<std::int32_t>(std::clamp((expected + difference) * step, -kTooLarge, kTooLarge));
    return static_cast<std::uint32_t>(std::abs(std::int64_t{difference}));
  }

  std::size_t code_face(std::size_t predicted, std::size_t face) {
    if (coder_.code(models_.same_face, face == predicted)) return predicted;
    const bool high = coder_.code(models_.face[0], (face & 2U) != 0);
    const bool low = coder_.code(models_.face[high ? 2 : 1], (face & 1U) != 0);
    return (high ? 2U : 0U) + (low ? 1U : 0U);
  }

  Coder& coder_;
  DeformationModels& models_;
  bool all_fine_;
};

} // namespace kinora::clip
