#include "tracking/deforming/pose_prediction.h"

#include <gtest/gtest.h>

#include "tracking/scenes/plate_layer.h"

namespace kinora::tracking {
namespace {

using testing::frame_of;
using testing::PlateLayer;
using testing::shift;
using testing::small_plate;
using Vec = Eigen::Vector3d;

TEST(PosePrediction, FollowsALayerThatJumpsAsAWhole) {
  const PlateLayer layer(small_plate({-0.15, 0, 1}));
  const LayerView there = view_layer(frame_of(small_plate({0.1, 0.05, 1.05})), 2);
  const ModelInView now = layer.in(there);
  const std::vector<SE3> last = layer.moved_by(shift(0, 0, 0));
  const TrackedView before{layer.view, layer.model.origin_to_camera(SE3::Identity())};
  const auto nodes = corrected_prediction(now, before, last, layer.binding, 1, last);
  for (const SE3& node : nodes) EXPECT_LT((node.translation() - Vec(0.25, 0.05, 0.05)).norm(), 0.03);
}

TEST(PosePrediction, LeavesALayerThatIsWhereItIsExpected) {
  const PlateLayer layer(small_plate({0, 0, 1}));
  const std::vector<SE3> last = layer.moved_by(shift(0, 0, 0));
  const TrackedView before{layer.view, layer.model.origin_to_camera(SE3::Identity())};
  const auto nodes = corrected_prediction(layer.in(layer.view), before, last, layer.binding, 1, last);
  for (const SE3& node : nodes) EXPECT_LT(node.translation().norm(), 1e-6);
}

} // namespace
} // namespace kinora::tracking
