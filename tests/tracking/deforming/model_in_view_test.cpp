#include "tracking/deforming/model_in_view.h"

#include <gtest/gtest.h>

#include "tracking/scenes/plate_layer.h"

namespace kinora::tracking {
namespace {

using testing::PlateLayer;
using testing::shift;
using testing::small_plate;

TEST(ModelInView, ShowsTheSurfaceWhereItIsAlone) {
  const PlateLayer layer(small_plate({0, 0, 1}));
  const ModelInView now = layer.in(layer.view);
  EXPECT_GT(now.facing_inlier_share(now.states(layer.moved_by(shift(0, 0, 0)))), 0.9);
  EXPECT_LT(now.facing_inlier_share(now.states(layer.moved_by(shift(0.15, 0, 0)))), 0.7);
  EXPECT_LT(now.facing_inlier_share(now.states(layer.moved_by(shift(0, 0, 0.1)))), 0.1);
  EXPECT_EQ(now.facing_inlier_share(now.states(layer.moved_by(shift(0, 0, 0))),
                                    [](const motion::Influence&) { return false; }),
            0);
}

TEST(ModelInView, GivesBackTransformsOfStates) {
  const PlateLayer layer(small_plate({0, 0, 1}));
  const ModelInView now = layer.in(layer.view);
  const std::vector<SE3> nodes = layer.moved_by(testing::pose_at({0.1, 0, 0}, 0, 20));
  EXPECT_TRUE(now.transforms(now.states(nodes))[3].isApprox(nodes[3], 1e-9));
}

} // namespace
} // namespace kinora::tracking
