// A person leaves the view and comes back elsewhere, in another pose.
#include <algorithm>

#include <gtest/gtest.h>

#include "motion/point_track.h"
#include "tracking/body/synthetic_body.h"
#include "tracking/deforming/deforming_tracker.h"

namespace kinora::tracking {
namespace {

using Vec = Eigen::Vector3d;
using testing::render_body;
using testing::standing;

constexpr int kSeenBefore = 14;
constexpr int kAway = 10;
constexpr int kSeenAfter = 8;

BodyState person_at(int frame) {
  const bool is_back = frame >= kSeenBefore + kAway;
  BodyState state = standing(is_back ? 50 : 0);
  state.pose.root.translation() += is_back ? Vec(0.5, 0, 0.2) : Vec(-0.3 + 0.005 * frame, 0, 0);
  state.pose.angles.segment<3>(joints()[kLeftShoulder].first_angle) = Vec(0, -0.2, is_back ? 0.9 : -0.6);
  state.pose.angles[joints()[kLeftElbow].first_angle] = is_back ? 1.6 : 0.3;
  return state;
}

ingest::Frame frame_at(int frame) {
  testing::BodyScene scene;
  scene.seed = static_cast<std::uint64_t>(frame);
  BodyState state = person_at(frame);
  const bool is_away = frame >= kSeenBefore && frame < kSeenBefore + kAway;
  if (is_away) state.pose.root.translation().x() += 10;
  ingest::Frame picture = render_body(state, scene);
  picture.index = frame;
  picture.time = frame / 30.0;
  return picture;
}

/// A point on a bone, in its space.
struct Mark {
  Joint bone;
  Vec local;
  double bound; ///< metres; without bones the upper arm was 27 cm off and the forearm 55 cm
};

// Trunk, limbs and head: the canonical model survives, and the graph goes on where the person is.
TEST(LostPerson, IsFoundAgainElsewhereInAnotherPose) {
  constexpr int kCount = kSeenBefore + kAway + kSeenAfter;
  DeformingTracker tracker(1);
  for (int i = 0; i < kCount; ++i) {
    const bool is_away = i >= kSeenBefore && i < kSeenBefore + kAway;
    EXPECT_EQ(tracker.track(frame_at(i)).health, is_away ? motion::Health::kHeld : motion::Health::kTracked) << i;
  }
  const motion::Motion motion = tracker.motion();
  for (const Mark& mark : {Mark{kChest, {0, 0.1, 0.12}, 0.04}, Mark{kHead, {0, 0.1, 0.1}, 0.04},
                           Mark{kLeftShoulder, {0.13, 0, 0.04}, 0.04}, Mark{kLeftElbow, {0.13, 0, 0.035}, 0.15},
                           Mark{kRightElbow, {-0.13, 0, 0.035}, 0.04}, Mark{kLeftKnee, {0, -0.2, 0.05}, 0.04}}) {
    const auto position = [&](int frame) {
      const BodyState state = person_at(frame);
      return Vec(forward_kinematics(state.pose, state.shape)[mark.bone] * mark.local);
    };
    const auto track = motion::track_point(motion, kCount, 0, position(0));
    EXPECT_LT((track.back() - position(kCount - 1)).norm(), mark.bound) << mark.bone;
  }
}

// Turned and with an arm raised, then facing the camera; away; and back elsewhere as in the first frames.
BodyState turning_person_at(int frame, double degrees) {
  constexpr int kTurned = 28;
  const bool is_back = frame >= kTurned + kAway;
  const double t = is_back ? 0 : std::min(1.0, std::max(0, frame - 4) / (kTurned - 6.0));
  BodyState state = standing(degrees * (1 - t));
  state.pose.root.translation() += is_back ? Vec(0.4, 0, 0.2) : Vec(-0.2, 0, 0);
  state.pose.angles.segment<3>(joints()[kLeftShoulder].first_angle) = Vec(0, -0.2, 0.7 - 1.5 * t);
  state.pose.angles[joints()[kLeftElbow].first_angle] = 1.4 - 1.1 * t;
  if (frame >= kTurned && !is_back) state.pose.root.translation().x() += 10;
  return state;
}

class TurnedLostPerson : public ::testing::TestWithParam<int> {};

TEST_P(TurnedLostPerson, IsFoundAgainInAPoseSeenBefore) {
  constexpr int kCount = 28 + kAway + kSeenAfter;
  DeformingTracker tracker(1);
  for (int i = 0; i < kCount; ++i) {
    testing::BodyScene scene;
    scene.seed = static_cast<std::uint64_t>(i);
    ingest::Frame picture = render_body(turning_person_at(i, GetParam()), scene);
    picture.index = i;
    picture.time = i / 30.0;
    tracker.track(picture);
  }
  const motion::Motion motion = tracker.motion();
  const bool back = GetParam() > 90;
  for (const Mark& mark :
       {Mark{kChest, {0, 0.1, back ? -0.08 : 0.12}, 0.04}, Mark{kHead, {0, 0.1, back ? -0.08 : 0.1}, 0.04},
        Mark{kLeftShoulder, {0.13, 0, back ? -0.04 : 0.04}, 0.04},
        Mark{kLeftElbow, {0.13, 0, back ? -0.035 : 0.035}, 0.03},
        Mark{kLeftKnee, {0, -0.2, back ? -0.05 : 0.05}, 0.04}}) {
    const auto position = [&](int frame) {
      const BodyState state = turning_person_at(frame, GetParam());
      return Vec(forward_kinematics(state.pose, state.shape)[mark.bone] * mark.local);
    };
    const auto track = motion::track_point(motion, kCount, 0, position(0));
    EXPECT_LT((track.back() - position(kCount - 1)).norm(), mark.bound) << mark.bone;
  }
}
INSTANTIATE_TEST_SUITE_P(Turns, TurnedLostPerson, ::testing::Values(90, 160));

} // namespace
} // namespace kinora::tracking
