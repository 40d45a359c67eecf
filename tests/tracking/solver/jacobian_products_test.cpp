#include "tracking/solver/jacobian_products.h"

#include "core/random.h"
#include "support/every_instruction_set.h"

namespace kinora::tracking {
namespace {

class JacobianProductsTest : public OnEveryInstructionSet {};

TEST_P(JacobianProductsTest, AreThoseOfPlainLoops) {
  constexpr std::size_t kBlocks = 7;
  Random random(3);
  std::vector<PointJacobians> points(50);
  std::vector<PointIncidence> uses;
  for (std::size_t p = 0; p < points.size(); ++p) {
    points[p].empty = p % 5 == 4;
    for (float& residual : points[p].residuals) residual = static_cast<float>(random.normal());
    for (auto& rows : points[p].by_node) {
      for (PointJacobians::Row& row : rows) {
        row.fill(0);
        for (std::size_t i = 0; i < 6; ++i) row[i] = static_cast<float>(random.normal());
      }
    }
    PointIncidence use{static_cast<std::uint32_t>(p), static_cast<std::uint32_t>(p % motion::Influence::kMax), {}};
    for (std::size_t k = 0; k < use.blocks.size(); ++k) {
      use.blocks[k] = (p + k) % 3 == 0 ? PointIncidence::kNone : static_cast<std::uint32_t>((p + 2 * k) % kBlocks);
    }
    uses.push_back(use);
  }
  std::vector<Block> blocks(kBlocks);
  PointJacobians::Row gradient{};
  add_jacobian_products(uses, points, blocks, gradient);

  std::array<std::array<std::array<double, 6>, 6>, kBlocks> expected{};
  std::array<double, 6> expected_gradient{};
  for (const PointIncidence& use : uses) {
    const PointJacobians& point = points[use.point];
    if (point.empty) continue;
    for (std::size_t r = 0; r < PointJacobians::kRows; ++r) {
      const PointJacobians::Row& jacobian = point.by_node[use.slot][r];
      for (std::size_t i = 0; i < 6; ++i) {
        expected_gradient[i] += jacobian[i] * point.residuals[r];
        for (std::size_t k = 0; k < use.blocks.size(); ++k) {
          if (use.blocks[k] == PointIncidence::kNone) continue;
          for (std::size_t c = 0; c < 6; ++c) expected[use.blocks[k]][c][i] += jacobian[i] * point.by_node[k][r][c];
        }
      }
    }
  }
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_NEAR(gradient[i], expected_gradient[i], 1e-4);
    for (std::size_t b = 0; b < kBlocks; ++b) {
      for (std::size_t c = 0; c < 6; ++c)
        EXPECT_NEAR(blocks[b].columns[c][i], expected[b][c][i], 1e-4) << b << ' ' << c;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Sets, JacobianProductsTest, every_instruction_set(), name_of_set);

} // namespace
} // namespace kinora::tracking
