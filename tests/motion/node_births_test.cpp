#include "motion/node_births.h"

#include <gtest/gtest.h>

#include "core/random.h"

namespace kinora::motion {
namespace {

Influence influence_of(std::initializer_list<std::pair<int, double>> weights) {
  Influence influence;
  for (const auto& [node, weight] : weights) {
    influence.nodes[static_cast<std::size_t>(influence.count)] = node;
    influence.weights[static_cast<std::size_t>(influence.count++)] = weight;
  }
  return influence;
}

TEST(NodeBirths, AreAtTheStartUnlessSomeAreLater) {
  EXPECT_TRUE(NodeBirths().are_at_the_start());
  EXPECT_TRUE(NodeBirths({0, 0, 0}).are_at_the_start());
  EXPECT_FALSE(NodeBirths({0, 2}).are_at_the_start());
  EXPECT_TRUE(NodeBirths().unborn(0).empty());
}

TEST(NodeBirths, ANodeIsUnbornUpToItsFrame) {
  const NodeBirths births({0, 3, 5});
  EXPECT_EQ(births.unborn(0), (UnbornNodes{false, true, true}));
  EXPECT_EQ(births.unborn(2.9), (UnbornNodes{false, true, true}));
  EXPECT_EQ(births.unborn(3), (UnbornNodes{false, false, true}));
  EXPECT_TRUE(births.unborn(5).empty());
}

TEST(NodeBirths, APointIsThereWhenHalfOfWhatMovesItIs) {
  const UnbornNodes unborn{false, true};
  EXPECT_FALSE(is_unborn(influence_of({{0, 0.5}, {1, 0.5}}), unborn));
  EXPECT_TRUE(is_unborn(influence_of({{1, 0.6}, {0, 0.4}}), unborn));
  EXPECT_FALSE(is_unborn(influence_of({{0, 1}}), unborn));
  EXPECT_FALSE(is_unborn(influence_of({}), unborn));
  EXPECT_FALSE(is_unborn(influence_of({{1, 1}}), {}));
}

TEST(NodeBirths, TheBirthOfAPointIsTheFirstFrameAtWhichItIsNotUnborn) {
  Random random(3);
  for (int round = 0; round < 500; ++round) {
    std::vector<std::uint32_t> frames(4);
    for (std::uint32_t& frame : frames) frame = random.below(5);
    const NodeBirths births(frames);
    Influence influence;
    influence.count = 1 + static_cast<int>(random.below(4));
    double sum = 0;
    for (std::size_t k = 0; k < static_cast<std::size_t>(influence.count); ++k) {
      influence.nodes[k] = static_cast<int>(k);
      sum += influence.weights[k] = 0.01 + random.uniform_double();
    }
    for (double& weight : influence.weights) weight /= sum;
    std::uint32_t first = 0;
    while (is_unborn(influence, births.unborn(first))) ++first;
    EXPECT_EQ(births.birth_of(influence), first);
  }
}

TEST(NodeBirths, OfAShorterClipAreNeverBeyondItsEnd) {
  EXPECT_EQ(NodeBirths({0, 3, 5}).in_first_frames(4), NodeBirths({0, 3, 4}));
}

} // namespace
} // namespace kinora::motion
