#include "tracking/solver/arap_term.h"

#include <cmath>

#include "core/random.h"
#include "core/robust_cost.h"
#include "support/every_instruction_set.h"

namespace kinora::tracking {
namespace {

constexpr double kSigma = 0.005;
constexpr Huber kHuber{kHuberThreshold};

class ArapTermTest : public OnEveryInstructionSet {};

TEST_P(ArapTermTest, AreThoseOfAPlainLoop) {
  Random random(6);
  const auto vector = [&](double size) {
    return Eigen::Vector3d(size * random.normal(), size * random.normal(), size * random.normal());
  };
  std::vector<Eigen::Vector3d> nodes;
  motion::NodeStates states;
  for (int n = 0; n < 30; ++n) {
    nodes.push_back(vector(0.05));
    Twist twist;
    twist << vector(0.005) + Eigen::Vector3d(0.5, 0, 2), vector(0.05);
    states.push_back(DualQuaternion::from(exp_se3(twist)), nodes.back());
  }
  std::vector<GraphEdge> edges(77);
  for (int e = 0; e < 77; ++e) edges[static_cast<std::size_t>(e)] = {e % 30, (e + 1 + e / 30) % 30};
  const std::vector<ArapEdge> rows = rows_of(edges, nodes);
  std::vector<ArapResiduals> residuals(edges.size());
  const double energy = arap_energy(rows, rows_of(states), kSigma, kHuber.threshold, residuals);
  EXPECT_EQ(arap_energy(rows, rows_of(states), kSigma, kHuber.threshold), energy);
  double expected = 0;
  for (std::size_t e = 0; e < edges.size(); ++e) {
    for (const bool there : {true, false}) {
      const auto i = static_cast<std::size_t>(there ? edges[e].a : edges[e].b);
      const auto j = static_cast<std::size_t>(there ? edges[e].b : edges[e].a);
      const Eigen::Vector3d residual =
          states.positions[i] + states.transforms[i].real * (nodes[j] - nodes[i]) - states.positions[j];
      const double size = residual.norm() / kSigma;
      expected += kHuber.cost(size);
      const ArapResidual& found = residuals[e][there ? 0 : 1];
      EXPECT_LT((found.value.cast<double>() - residual).norm(), 2e-6) << e;
      EXPECT_NEAR(found.weight * kSigma * kSigma, kHuber.weight(size), 1e-3) << e;
    }
  }
  EXPECT_NEAR(energy, expected, 1e-3 * expected);
}

INSTANTIATE_TEST_SUITE_P(Sets, ArapTermTest, every_instruction_set(), name_of_set);

} // namespace
} // namespace kinora::tracking
