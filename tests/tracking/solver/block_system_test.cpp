#include "tracking/solver/pcg.h"

#include "core/random.h"
#include "support/every_instruction_set.h"

namespace kinora::tracking {
namespace {

class BlockSystemTest : public OnEveryInstructionSet {};

Twist random_twist(Random& random) {
  Twist twist;
  for (double& value : twist) value = random.normal();
  return twist;
}

/// Sums of squares of rows that each tie two nodes: positive semidefinite, as the solver meets them.
BlockSystem random_system(const BlockPattern& pattern, std::size_t rows, Random& random) {
  BlockSystem system;
  system.blocks.resize(pattern.block_count());
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
    const auto add = [&](int row, int column, const Twist& left, const Twist& right) {
      system.blocks[pattern.find(row, column)].matrix() += (left * right.transpose()).cast<float>();
    };
    add(a, a, ja, ja);
    add(b, b, jb, jb);
    if (a != b) {
      add(a, b, ja, jb);
      add(b, a, jb, ja);
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

TEST_P(BlockSystemTest, ConjugateGradientsAgreeWithTheDenseSolution) {
  Random random(7);
  const BlockPattern pattern = ring(30);
  const BlockSystem system = random_system(pattern, 900, random);
  const std::vector<Twist> added = damping_of(pattern, system, 1e-3, 1e-6);
  const std::vector<Twist> exact = solve_dense(pattern, system, added);
  const PcgResult found = solve_pcg(pattern, system, added, 2000, 1e-7);
  for (std::size_t i = 0; i < exact.size(); ++i)
    EXPECT_LT((exact[i] - found.step[i]).norm(), 1e-5 * (1 + exact[i].norm())) << "node " << i;
}

TEST_P(BlockSystemTest, APartialSolutionAlreadyLowersTheModel) {
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

TEST_P(BlockSystemTest, NodesThatNothingHoldsStayWhereTheyAre) {
  const BlockPattern pattern = ring(5);
  BlockSystem system;
  system.blocks.resize(pattern.block_count());
  system.gradient.assign(5, Twist::Zero());
  const PcgResult empty = solve_pcg(pattern, system, damping_of(pattern, system, 1e-3, 1e-6), 50, 1e-6);
  for (const Twist& step : empty.step) EXPECT_EQ(step, Twist::Zero());
  system.blocks[pattern.find(2, 2)].matrix().setIdentity();
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

TEST(BlockPattern, KnowsDiagonalsAndTransposes) {
  const BlockPattern pattern = ring(12);
  for (std::size_t row = 0; row < 12; ++row) {
    EXPECT_EQ(pattern.diagonal(row), pattern.find(static_cast<int>(row), static_cast<int>(row)));
    for (std::size_t b = pattern.row_begin(row); b < pattern.row_end(row); ++b) {
      EXPECT_EQ(pattern.transposed(b), pattern.find(pattern.column(b), static_cast<int>(row)));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Sets, BlockSystemTest, every_instruction_set(), name_of_set);

} // namespace
} // namespace kinora::tracking
