#include "fields/training/hidden_cells.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "fields/model/enclosed_cells.h"
#include "fields/rendering/renderer.h"
#include "fields/scenes/drawn_scene.h"
#include "fields/scenes/same_cells.h"

namespace kinora::fields {
namespace {

using testing::camera_at;
using testing::kBox;
using testing::kCell;
using testing::kPaintedCells;
using testing::Paint;
using testing::painted_field;
using testing::PaintedBall;

Picture draw(const Field& field, const Camera& camera) {
  const DrawableField drawable(field, nullptr, std::nullopt);
  const PosedField posed{&drawable, SE3::Identity()};
  return render({&posed, 1}, camera);
}

TEST(HiddenCells, TheInsideOfABallGoesAndNoPictureChanges) {
  const Field whole = painted_field(kBox, PaintedBall{});
  Field hollow = whole;
  const std::size_t emptied = empty_hidden_cells(hollow);
  EXPECT_EQ(hollow.occupancy.count() + emptied, whole.occupancy.count());
  EXPECT_LT(hollow.occupancy.count(), whole.occupancy.count() * 2 / 3);
  // All of what went is solid, and nothing else is.
  const Occupancy enclosed = enclosed_cells(hollow.occupancy);
  for (std::size_t w = 0; w < enclosed.words().size(); ++w) {
    ASSERT_EQ(enclosed.words()[w], whole.occupancy.words()[w] & ~hollow.occupancy.words()[w]);
  }
  for (int i = 0; i < 8; ++i) {
    const double a = 2 * std::numbers::pi * i / 8;
    const Camera camera = camera_at({1.1 * std::sin(a), 0.7 * std::sin(2 * a), 1.1 * std::cos(a)}, {0, 0, 0});
    const Picture hollow_picture = draw(hollow, camera), whole_picture = draw(whole, camera);
    EXPECT_TRUE(std::ranges::equal(hollow_picture.color.values(), whole_picture.color.values())) << i;
  }
}

TEST(HiddenCells, BehindWhatLetsLightThroughNothingGoes) {
  constexpr float kThin = 0.05F; // logarithm of the density: the ball takes little of the light
  Field field = painted_field(kBox, PaintedBall{Eigen::Vector3d::Zero(), 4 * kCell}, kThin);
  EXPECT_EQ(empty_hidden_cells(field), 0U);
}

TEST(HiddenCells, ACavityShowsNobodyItsWalls) {
  const auto shell = [](const Eigen::Vector3d& p) { return Paint{std::abs(p.norm() - 0.3) - 0.1, {1, 1, 1}}; };
  Field field = painted_field(kBox, shell);
  empty_hidden_cells(field);
  const int middle = kPaintedCells / 2;
  const auto cell_at = [](double x) { return static_cast<int>((x + 0.5) / kCell); };
  EXPECT_FALSE(field.occupancy.at(cell_at(0.21), middle, middle)); // the wall's inner side
  EXPECT_TRUE(field.occupancy.at(cell_at(0.39), middle, middle));
}

TEST(HiddenCells, AreTheSameForAnyNumberOfThreads) {
  testing::expect_same_cells_for_any_number_of_threads(painted_field(kBox, PaintedBall{}),
                                                       [](Field& field) { empty_hidden_cells(field); });
}

} // namespace
} // namespace kinora::fields
