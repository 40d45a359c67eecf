#include "tracking/deforming/backward_smoothing.h"

#include <gtest/gtest.h>

#include "tracking/scenes/plate_layer.h"

namespace kinora::tracking {
namespace {

using testing::PlateLayer;
using testing::small_plate;
using Vec = Eigen::Vector3d;

// Two frames of one plate, of which the first remembers half of the nodes where they were not.
struct Doubtful {
  PlateLayer plate{small_plate({0, 0, 1})};
  FrameHistory memory;
  NodeTrajectory trajectory{0, plate.model.nodes().size(), 0};
  std::vector<std::size_t> doubted;

  Doubtful() {
    for (int i = 0; i < 2; ++i) memory.add(plate.frame, plate.view);
    std::vector<SE3> nodes = trajectory.last().nodes;
    trajectory.add_tracked(nodes, 1);
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      if (plate.model.nodes()[n].x() > 0) continue;
      nodes[n].translation() = Vec(0, 0, 0.03);
      doubted.push_back(n);
    }
    trajectory.correct(0, nodes);
  }

  void smooth() { smooth_backward(memory, 2, plate.model, plate.binding, plate.config, {}, trajectory); }
  double mean_error() const {
    double sum = 0;
    for (const std::size_t n : doubted) {
      const Vec& node = plate.model.nodes()[n];
      sum += (trajectory.at(0).nodes[n] * node - node).norm();
    }
    return sum / static_cast<double>(doubted.size());
  }
};

TEST(BackwardSmoothing, FollowsGuessesBack) {
  Doubtful layer;
  for (const std::size_t n : layer.doubted) layer.trajectory.mark_past_extrapolated(n);
  EXPECT_NEAR(layer.mean_error(), 0.03, 1e-9);
  layer.smooth();
  EXPECT_LT(layer.mean_error(), 0.01);
}

TEST(BackwardSmoothing, LeavesWhatWasSeen) {
  Doubtful layer;
  layer.smooth();
  EXPECT_NEAR(layer.mean_error(), 0.03, 1e-9);
}

} // namespace
} // namespace kinora::tracking
