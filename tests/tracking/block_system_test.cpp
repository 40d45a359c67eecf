#include "tracking/block_system.h"

#include <gtest/gtest.h>

#include "core/random.h"

namespace kinora::tracking {
namespace {

Twist random_twist(Random& random) {
  Twist twist;
  for (double& value : twist) value = random.normal();
  return twist;
}

/// Sums of squares of rows that each tie two nodes: positive semidefinite, as the solver meets them.
BlockSystem random_system(const BlockPattern& pattern, std::size_t rows, Random& random) {
  BlockSystem system;
  system.blocks.assign(pattern.block_count(), Block::Zero());
  system.gradient.assign(pattern.node_count(), Twist::Zero());
  for (std::size_t r = 0; r < rows; ++r) {
    const int a = static_cast<int>(random.below(static_cast<std::uint32_t>(pattern.node_count())));
    const std::size_t within =
        pattern.row_end(static_cast<std::size_t>(a)) - pattern.row_begin(static_cast<std::size_t>(a));
    const int b = pattern.column(pattern.row_begin(static_cast<std::size_t>(a)) +
                                 random.below(static_cast<std::uint32_t>(within)));
    const Twist ja = random_twist(random);
    const Twist jb = a == b ? Twist(Twist::Zero()) : random_twist(random);
    const double residual = random.normal();
    system.blocks[pattern.find(a, a)] += ja * ja.transpose();
    system.blocks[pattern.find(b, b)] += jb * jb.transpose();
    if (a != b) {
      system.blocks[pattern.find(a, b)] += ja * jb.transpose();
      system.blocks[pattern.find(b, a)] += jb * ja.transpose();
    }
    system.gradient[static_cast<std::size_t>(a)] += residual * ja;
    system.gradient[static_cast<std::size_t>(b)] += residual * jb;
  }
  return system;
}

BlockPattern ring(std::size_t nodes) {
  std::vector<BlockPattern::Pair> pairs;
  for (std::size_t i = 0; i < nodes; ++i) {
    pairs.push_back({static_cast<int>(i), static_cast<int>((i + 1) % nodes)});
    pairs.push_back({static_cast<int>(i), static_cast<int>((i + 3) % nodes)});
  }
  return {nodes, pairs};
}

TEST(BlockSystem, ConjugateGradientsAgreeWithTheDenseSolution) {
  Random random(7);
  const BlockPattern pattern = ring(30);
  const BlockSystem system = random_system(pattern, 900, random);
  const std::vector<Twist> added = damping_of(pattern, system, 1e-3, 1e-6);
  const std::vector<Twist> exact = solve_dense(pattern, system, added);
  const PcgResult found = solve_pcg(pattern, system, added, 2000, 1e-12);
  for (std::size_t i = 0; i < exact.size(); ++i) EXPECT_LT((exact[i] - found.step[i]).norm(), 1e-7) << "node " << i;
}

TEST(BlockSystem, APartialSolutionAlreadyLowersTheModel) {
  Random random(8);
  const BlockPattern pattern = ring(40);
  const BlockSystem system = random_system(pattern, 600, random);
  const std::vector<Twist> added = damping_of(pattern, system, 1e-3, 1e-6);
  double before = 0;
  for (const int iterations : {1, 3, 10, 40}) {
    const double change = model_change(pattern, system, solve_pcg(pattern, system, added, iterations, 0).step);
    EXPECT_LT(change, before);
    before = change;
  }
}

TEST(BlockSystem, NodesThatNothingHoldsStayWhereTheyAre) {
  const BlockPattern pattern = ring(5);
  BlockSystem system;
  system.blocks.assign(pattern.block_count(), Block::Zero());
  system.gradient.assign(5, Twist::Zero());
  const PcgResult empty = solve_pcg(pattern, system, damping_of(pattern, system, 1e-3, 1e-6), 50, 1e-6);
  for (const Twist& step : empty.step) EXPECT_EQ(step, Twist::Zero());
  system.blocks[pattern.find(2, 2)] = Block::Identity();
  system.gradient[2] = Twist::Constant(1);
  const PcgResult one = solve_pcg(pattern, system, damping_of(pattern, system, 1e-3, 1e-6), 50, 1e-6);
  EXPECT_LT((one.step[2] + Twist::Constant(1 / 1.001)).norm(), 1e-6);
  EXPECT_EQ(one.step[0], Twist::Zero());
}

TEST(BlockPattern, KeepsEachPairOnceInBothRows) {
  const std::vector<BlockPattern::Pair> pairs = {{0, 2}, {2, 0}, {0, 2}, {1, 1}};
  const BlockPattern pattern(3, pairs);
  EXPECT_EQ(pattern.block_count(), 5U);
  EXPECT_EQ(pattern.column(pattern.find(0, 2)), 2);
  EXPECT_EQ(pattern.column(pattern.find(2, 0)), 0);
}

} // namespace
} // namespace kinora::tracking
