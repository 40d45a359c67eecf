// How well each side of a surface is said to have been seen.
#include <gtest/gtest.h>

#include "core/parallel.h"
#include "fields/rendering/renderer.h"
#include "fields/scenes/analytic_scene.h"
#include "fields/scenes/drawn_scene.h"
#include "fields/training/view_confidence.h"

namespace kinora::fields {
namespace {

using testing::camera_at;
using testing::painted_field;
using testing::PaintedBall;

constexpr int kBall = 2;
constexpr int kFrames = 30;
const Scene kScene;
const motion::Motion kStill = motion::Motion::still();

const Field& ball_field() {
  const FieldBox box{kScene.centre - Eigen::Vector3d::Constant(0.5), 1};
  static const Field field = painted_field(box, PaintedBall{kScene.centre, kScene.radius});
  return field;
}

/// From a camera at the origin, turned about the ball.
Confidence seen(int frames, double angle = 0) {
  PixelStore store(1'000'000, static_cast<std::size_t>(frames));
  for (int i = 0; i < frames; ++i) store.add(kScene.frame(i, angle), i);
  return view_confidence({store, kBall, kStill}, ball_field());
}

/// Of the ball's surface out along a unit vector.
float at(const Confidence& confidence, const Eigen::Vector3d& out) {
  const FieldBox& box = ball_field().config.box;
  const Eigen::Vector3f position = ((kScene.centre + kScene.radius * out - box.origin) / box.side).cast<float>();
  return confidence.at({position.x(), position.y(), position.z()}, out.cast<float>());
}

/// Degrees away from the camera that stood before the ball, towards x.
Eigen::Vector3d rotated(double degrees) {
  const double angle = degrees * EIGEN_PI / 180;
  return {std::sin(angle), 0, -std::cos(angle)};
}

TEST(Confidence, IsHighInFrontNothingBehindAndFallsTowardsTheRim) {
  const Confidence confidence = seen(kFrames);
  EXPECT_GT(at(confidence, rotated(0)), 0.8F);
  EXPECT_GT(at(confidence, rotated(20)), 0.8F);
  EXPECT_LT(at(confidence, rotated(70)), 0.5F * at(confidence, rotated(0)));
  EXPECT_GT(at(confidence, rotated(55)), at(confidence, rotated(75)));
  for (const double behind : {95.0, 120.0, 150.0, 180.0}) EXPECT_LT(at(confidence, rotated(behind)), 0.05F) << behind;
}

TEST(Confidence, OfWhatWasSeenFromAsideFallsWithTheCosine) {
  const Confidence confidence = seen(kFrames);
  EXPECT_NEAR(at(confidence, rotated(50)), std::cos(50 * EIGEN_PI / 180) * at(confidence, rotated(0)), 0.09);
}

TEST(Confidence, FollowsTheCameraAroundTheBall) {
  for (const double angle : {0.4, 1.2, 2.9}) {
    const Confidence confidence = seen(kFrames, angle);
    const Eigen::Vector3d front = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY()) * rotated(0);
    EXPECT_GT(at(confidence, front), 0.8F) << angle;
    EXPECT_LT(at(confidence, -front), 0.05F) << angle;
  }
}

TEST(Confidence, OfWhatWasSeenOnceFromTheFrontIsAboutOneHalfAndGrowsWithEveryView) {
  EXPECT_NEAR(at(seen(1), rotated(0)), 0.5, 0.2);
  Confidence before = seen(1);
  for (const int frames : {2, 5, 12, 30}) {
    const Confidence more = seen(frames);
    EXPECT_GT(at(more, rotated(0)), at(before, rotated(0))) << frames;
    for (std::size_t b = 0; b < more.levels().size(); ++b) {
      for (std::size_t d = 0; d < Confidence::kNormals; ++d) EXPECT_GE(more.levels()[b][d], before.levels()[b][d]);
    }
    before = more;
  }
}

// Half of the pixels stand for all of them.
TEST(Confidence, DoesNotDependOnHowManyPixelsAreStored) {
  PixelStore store(kFrames * kWidth * kHeight / 2, kFrames);
  for (int i = 0; i < kFrames; ++i) store.add(kScene.frame(i, 0), i);
  const Confidence half = view_confidence({store, kBall, kStill}, ball_field());
  EXPECT_NEAR(at(half, rotated(0)), at(seen(kFrames), rotated(0)), 0.05);
}

TEST(Confidence, OfALayerThatMovesIsInItsCanonicalSpace) {
  // The ball turns half about the vertical between two frames; a still camera sees both sides.
  PixelStore store(1'000'000, 2 * kFrames);
  std::vector<motion::Motion::Pose> poses;
  for (int i = 0; i < 2 * kFrames; ++i) {
    SE3 pose = SE3::Identity();
    pose.translate(kScene.centre).rotate(Eigen::AngleAxisd(i < kFrames ? 0 : EIGEN_PI, Eigen::Vector3d::UnitY()));
    pose.translate(-kScene.centre);
    poses.push_back({pose, motion::Health::kTracked});
    store.add(kScene.frame(i, 0), i);
  }
  const Confidence confidence = view_confidence({store, kBall, motion::Motion::rigid(std::move(poses))}, ball_field());
  EXPECT_GT(at(confidence, rotated(0)), 0.8F);
  EXPECT_GT(at(confidence, rotated(180)), 0.8F);
  EXPECT_LT(at(confidence, rotated(90)), 0.3F);
}

class DrawnConfidence : public ::testing::Test {
protected:
  Picture draw(double degrees, const DrawOptions& options = {.confidence = true}) const {
    const PosedField posed{&field_};
    return render({&posed, 1}, camera_at(kScene.centre + 1.2 * rotated(degrees), kScene.centre), options);
  }
  DrawableField field_{ball_field(), nullptr, seen(kFrames)};
};

TEST_F(DrawnConfidence, IsThatOfTheSideWhichIsSeen) {
  const Picture front = draw(0);
  EXPECT_GT(front.confidence.at(48, 36), 204);
  const Picture back = draw(180);
  ASSERT_GT(back.depth.at(48, 36), 0);
  for (const std::uint8_t confidence : back.confidence.values()) EXPECT_LT(confidence, 26);
}

// The ball's left half was before the capture's camera, which stood on the left.
TEST_F(DrawnConfidence, FromTheSideEndsInTheMiddle) {
  const Picture side = draw(90);
  double left = 0, right = 0;
  for (int v = 0; v < 72; ++v) {
    for (int u = 0; u < 96; ++u) (u < 48 ? left : right) += side.confidence.at(u, v);
  }
  EXPECT_GT(std::max(left, right), 20 * std::min(left, right));
}

TEST_F(DrawnConfidence, IsDrawnOnlyForThoseWhoAskAndChangesNothingElse) {
  const Picture plain = draw(30, {});
  const Picture asked = draw(30);
  EXPECT_TRUE(plain.confidence.empty());
  EXPECT_TRUE(std::ranges::equal(plain.color.values(), asked.color.values()));
}

TEST_F(DrawnConfidence, IsNothingForFieldsOfWhichItIsNotKnown) {
  const DrawableField unknown(ball_field());
  const PosedField posed{&unknown};
  const Picture picture =
      render({&posed, 1}, camera_at(kScene.centre + 1.2 * rotated(0), kScene.centre), {.confidence = true});
  for (const std::uint8_t confidence : picture.confidence.values()) EXPECT_EQ(confidence, 0);
}

TEST_F(DrawnConfidence, FadesWhatWasNeverSeenAndKeepsTheRest) {
  const auto opacity = [this](double degrees, Unseen unseen) {
    double sum = 0;
    const Picture picture = draw(degrees, {.unseen = unseen});
    for (std::size_t i = 0; i < picture.color.pixel_count(); ++i) sum += picture.color.data()[4 * i + 3];
    return sum;
  };
  EXPECT_GT(opacity(0, Unseen::kFade), 0.95 * opacity(0, Unseen::kKeep));
  EXPECT_LT(opacity(180, Unseen::kFade), 0.05 * opacity(180, Unseen::kKeep));
}

TEST_F(DrawnConfidence, ShowsWhatLiesBehindWhatFades) {
  const DrawableField unknown(ball_field());
  SE3 behind = SE3::Identity();
  behind.translate(-0.9 * rotated(180));
  const std::vector<PosedField> posed{{&field_}, {&unknown, behind}};
  const Camera camera = camera_at(kScene.centre + 1.2 * rotated(180), kScene.centre);
  const Picture kept = render(posed, camera);
  const Picture faded = render(posed, camera, {.unseen = Unseen::kFade});
  EXPECT_EQ(kept.front.at(48, 36), 1);
  EXPECT_EQ(faded.front.at(48, 36), 2);
  EXPECT_GT(faded.color.at(48, 36, 3), 240);
}

TEST_F(DrawnConfidence, FadesNoFieldOfWhichItIsNotKnown) {
  const DrawableField unknown(ball_field());
  const PosedField posed{&unknown};
  const Camera camera = camera_at(kScene.centre + 1.2 * rotated(180), kScene.centre);
  const Picture kept = render({&posed, 1}, camera);
  const Picture faded = render({&posed, 1}, camera, {.unseen = Unseen::kFade});
  EXPECT_TRUE(std::ranges::equal(kept.color.values(), faded.color.values()));
}

TEST_F(DrawnConfidence, IsAboutTheSameInPicturesOfEveryQuality) {
  const Picture full = draw(30);
  for (const DrawOptions& options : {DrawOptions{.quality = DrawQuality::kFast, .confidence = true},
                                     DrawOptions{.confidence = true, .samples = 4}}) {
    const Picture other = draw(30, options);
    for (const int u : {40, 48, 56}) EXPECT_NEAR(other.confidence.at(u, 36), full.confidence.at(u, 36), 20) << u;
  }
}

TEST_F(DrawnConfidence, SameBitsForAnyNumberOfThreads) {
  set_thread_count(1);
  const Confidence one = seen(3);
  const Picture drawn_by_one = draw(40);
  set_thread_count(7);
  const Confidence seven = seen(3);
  const Picture drawn_by_seven = draw(40);
  set_thread_count(0);
  EXPECT_EQ(one.levels(), seven.levels());
  EXPECT_TRUE(std::ranges::equal(drawn_by_one.confidence.values(), drawn_by_seven.confidence.values()));
}

} // namespace
} // namespace kinora::fields
