#include "tracking/deforming/new_components.h"

#include <limits>

#include <gtest/gtest.h>

#include "tracking/scenes/plate_layer.h"

namespace kinora::tracking {
namespace {

using testing::PlateLayer;

TEST(PersistentComponents, TakesInWhatKeepsApart) {
  const LayerView view = PlateLayer(testing::small_plate({0, 0, 1})).view;
  TsdfVolume::CanonicalMap nowhere;
  const auto cells = [&](int pixels) { return (pixels + nowhere.stride - 1) / nowhere.stride; };
  constexpr float kNowhere = std::numeric_limits<float>::quiet_NaN();
  nowhere.of_cell = Image<float>(cells(view.intrinsics.width), cells(view.intrinsics.height), 4, kNowhere);
  PersistentComponents pieces;
  for (int frame = 0; frame < 7; ++frame) EXPECT_TRUE(pieces.add(view, nowhere).empty()) << frame;
  const auto persistent = pieces.add(view, nowhere);
  ASSERT_EQ(persistent.size(), 1U);
  EXPECT_LT((persistent.front().centroid() - view.centroid).norm(), 0.02);
}

} // namespace
} // namespace kinora::tracking
