// One object after another in scenes that are hard to follow: shapes that may slide, sizes, hiding, light, no depth.
#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "core/parallel.h"
#include "tracking/rigid/rigid_tracker.h"
#include "tracking/scenes/synthetic_scene.h"

namespace kinora::tracking {
namespace {

using testing::pose_at;
using testing::render_frame;
using testing::SceneOptions;
using testing::Shape;
using testing::ShapeKind;

constexpr double kDegrees = 180 / 3.14159265358979;

/// Of a thing that must not be taken for one that bends, whatever the scene.
class RigidThing : public RigidTracker {
public:
  using RigidTracker::RigidTracker;
  RigidThing(RigidThing&&) = delete;
  RigidThing& operator=(RigidThing&&) = delete;
  ~RigidThing() { EXPECT_FALSE(non_rigidity()); }
};

struct Errors {
  double metres = 0; ///< at the object's centre
  double degrees = 0;
};

Errors error_of(const RigidTrackingResult& result, const SE3& first, const SE3& now) {
  const SE3& motion = result.pose.canonical_to_world;
  return {(motion * first.translation() - now.translation()).norm(),
          kDegrees * rotation_angle(motion.inverse() * now * first.inverse())};
}

void expect_tracked(const RigidTrackingResult& result, const SE3& first, const SE3& now, const Errors& bound, int i) {
  EXPECT_EQ(result.pose.health, motion::Health::kTracked) << "frame " << i;
  const Errors errors = error_of(result, first, now);
  EXPECT_LT(errors.metres, bound.metres) << "frame " << i;
  EXPECT_LT(errors.degrees, bound.degrees) << "frame " << i;
}

SceneOptions noisy() {
  SceneOptions options;
  options.noise = 1;
  return options;
}

// Carried about and turned, one metre away.
SE3 moving_pose(int i) {
  return pose_at({0.08 * std::sin(0.15 * i), 0.05 * std::cos(0.1 * i), 1 + 0.05 * std::sin(0.1 * i)}, 20 + 1.5 * i,
                 30 + 20 * std::sin(0.1 * i), 0.5 * i);
}

// How much of a direction lies in those that were left to the motion prior: 1 is all. Of two directions, of that
// between them which lies in most.
double degenerate_share(const RigidTrackingResult& result, int i, int j) {
  Eigen::Matrix2d shares = Eigen::Matrix2d::Zero();
  for (const Twist& degenerate : result.degenerate) {
    const Eigen::Vector2d part(degenerate[i], degenerate[j]);
    shares += part * part.transpose();
  }
  return shares.selfadjointView<Eigen::Lower>().eigenvalues().maxCoeff();
}
double degenerate_share(const RigidTrackingResult& result, int i) {
  double sum = 0;
  for (const Twist& degenerate : result.degenerate) sum += degenerate[i] * degenerate[i];
  return sum;
}

TEST(RigidScene, APlaneMaySlideButNeitherRiseNorTilt) {
  RigidThing tracker(2);
  for (int i = 0; i < 12; ++i) {
    const SE3 pose = pose_at({0, 0, 0.9 + 0.004 * i}, 0.4 * i, 0);
    const auto result =
        tracker.track(render_frame({ShapeKind::kPlane, {0, 0, 0}, false}, pose, SE3::Identity(), i, noisy()));
    ASSERT_EQ(result.pose.health, motion::Health::kTracked) << "frame " << i;
    const SE3 motion = result.pose.canonical_to_world * pose_at({0, 0, 0.9}, 0, 0);
    EXPECT_TRUE(motion.matrix().allFinite());
    EXPECT_LT(std::abs(pose.linear().col(2).dot(motion.translation() - pose.translation())), 0.002) << "frame " << i;
    EXPECT_GT(motion.linear().col(2).dot(pose.linear().col(2)), std::cos(0.5 / kDegrees)) << "frame " << i;
    EXPECT_LT(motion.translation().head<2>().norm(), 0.02) << "what nothing shows does not run away";
    if (i == 0) continue;
    EXPECT_EQ(result.degenerate_directions, 3) << "frame " << i;
    EXPECT_GT(degenerate_share(result, 0), 0.9);
    EXPECT_GT(degenerate_share(result, 1), 0.9);
    EXPECT_GT(degenerate_share(result, 5), 0.9);
  }
}

TEST(RigidScene, ACylinderMaySlideAndTurnAlongItsAxisAlone) {
  RigidThing tracker(2);
  const Shape pipe{ShapeKind::kCylinder, {0.1, 2, 0}, false};
  for (int i = 0; i < 12; ++i) {
    const SE3 pose = pose_at({0.004 * i, 0, 0.9 + 0.003 * i}, 0, 0, 0.3 * i);
    const auto result = tracker.track(render_frame(pipe, pose, SE3::Identity(), i, noisy()));
    ASSERT_EQ(result.pose.health, motion::Health::kTracked) << "frame " << i;
    const SE3 motion = result.pose.canonical_to_world * pose_at({0, 0, 0.9}, 0, 0);
    Eigen::Vector3d across = pose.linear().transpose() * (motion.translation() - pose.translation());
    across.y() = 0;
    EXPECT_LT(across.norm(), 0.003) << "frame " << i;
    EXPECT_GT(motion.linear().col(1).dot(pose.linear().col(1)), std::cos(0.7 / kDegrees)) << "frame " << i;
    if (i == 0) continue;
    EXPECT_EQ(result.degenerate_directions, 2) << "frame " << i;
    EXPECT_GT(degenerate_share(result, 1), 0.9);
    EXPECT_GT(degenerate_share(result, 0, 4), 0.9) << "the axis lies behind the middle of what is seen";
  }
}

TEST(RigidScene, TextureResolvesWhatShapeLeavesOpen) {
  struct Case {
    Shape shape;
    SE3 step;
  };
  const std::array<Case, 3> cases = {{{{ShapeKind::kPlane, {0, 0, 0}, true}, pose_at({0.004, -0.003, 0}, 0, 0, 0.5)},
                                      {{ShapeKind::kCylinder, {0.1, 2, 0}, true}, pose_at({0, 0.004, 0}, 0, 2)},
                                      {{ShapeKind::kSphere, {0.12, 0, 0}, true}, pose_at({0.003, 0, 0}, 1, 1.5, 1)}}};
  for (std::size_t kind = 0; kind < cases.size(); ++kind) {
    SCOPED_TRACE(kind);
    RigidThing tracker(2);
    const SE3 first = pose_at({0, 0, 0.9}, 0, 0);
    SE3 pose = first;
    for (int i = 0; i < 10; ++i, pose = pose * cases[kind].step) {
      const auto result = tracker.track(render_frame(cases[kind].shape, pose, SE3::Identity(), i, noisy()));
      expect_tracked(result, first, pose, {0.003, 1.0}, i);
      EXPECT_EQ(result.degenerate_directions, 0) << "frame " << i;
    }
  }
}

TEST(RigidScene, APlainPlateThatSlidesIsFollowedByItsRim) {
  const Shape plate{ShapeKind::kBox, {0.16, 0.11, 0.01}, false};
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE(seed);
    SceneOptions options = noisy();
    options.seed = seed;
    RigidThing tracker(2);
    const auto slid = [](int i) {
      return pose_at({0.12 * std::sin(0.15 * i), 0.06 * std::sin(0.1 * i), 0.9}, 0, 0, 10 * std::sin(0.12 * i));
    };
    for (int i = 0; i < 30; ++i) {
      const auto result = tracker.track(render_frame(plate, slid(i), SE3::Identity(), i, options));
      expect_tracked(result, slid(0), slid(i), {0.005, 1.5}, i);
    }
  }
}

TEST(RigidScene, LightOnAPlainBallIsNotTakenForItsPrint) {
  const Shape ball{ShapeKind::kSphere, {0.12, 0, 0}, false};
  RigidThing tracker(2);
  for (int i = 0; i < 12; ++i) {
    const SE3 pose = pose_at({0.004 * i, -0.002 * i, 1 + 0.003 * i}, 0, 0);
    ingest::Frame frame = render_frame(ball, pose, SE3::Identity(), i, noisy());
    for (int v = 0; v < frame.color.height(); ++v) {
      for (int u = 0; u < frame.color.width(); ++u) {
        if (frame.labels.at(u, v) != 2) continue;
        const Eigen::Vector3d ray = frame.camera.intrinsics.unproject(u, v, 1.0);
        const auto at =
            testing::intersect(ball, pose.inverse() * Eigen::Vector3d::Zero(), pose.inverse().linear() * ray);
        const double facing = at ? -(pose.inverse() * (*at * ray)).z() / 0.12 : 0.0;
        for (int c = 0; c < 3; ++c) {
          std::uint8_t& value = frame.color.pixel(u, v)[c];
          value = static_cast<std::uint8_t>(value * (0.4 + 0.6 * std::max(0.0, facing)));
        }
      }
    }
    const auto result = tracker.track(frame);
    ASSERT_EQ(result.pose.health, motion::Health::kTracked) << "frame " << i;
    if (i > 0) {
      EXPECT_EQ(result.degenerate_directions, 3) << "frame " << i;
    }
    const Eigen::Vector3d centre = result.pose.canonical_to_world * Eigen::Vector3d(0, 0, 1);
    EXPECT_LT((centre - pose.translation()).norm(), 0.003) << "frame " << i;
  }
}

TEST(RigidScene, HoldsAThingOfTwoCentimetresAndOneOfTwoMetres) {
  struct Case {
    double size;
    double distance;
    double focal;
    Errors bound;
  };
  for (const Case& c : {Case{0.02, 0.45, 525, {0.002, 6}}, Case{2, 3.5, 240, {0.02, 1}}}) {
    SCOPED_TRACE(c.size);
    SceneOptions options = noisy();
    options.focal = c.focal;
    RigidThing tracker(2);
    const Shape shape{ShapeKind::kBox, c.size * Eigen::Vector3d(0.5, 0.4, 0.3), true};
    const auto pose_of = [&c](int i) {
      return pose_at({0.05 * c.size * i, 0, c.distance + 0.03 * c.size * i}, 25 + i, 30 + i);
    };
    for (int i = 0; i < 12; ++i) {
      const auto result = tracker.track(render_frame(shape, pose_of(i), SE3::Identity(), i, options));
      expect_tracked(result, pose_of(0), pose_of(i), c.bound, i);
    }
  }
}

TEST(RigidScene, IsNeverWrongWhileItIsHiddenAndFoundAgainAfterwards) {
  RigidThing tracker(2);
  const SE3 first = moving_pose(0);
  const auto label_pixels = [](const ingest::Frame& frame) {
    const auto values = frame.labels.values();
    return static_cast<double>(std::count(values.begin(), values.end(), 2));
  };
  double most_hidden = 0;
  for (int i = 0; i < 40; ++i) {
    SceneOptions options = noisy();
    const double whole = label_pixels(render_frame({}, moving_pose(i), SE3::Identity(), i, options));
    options.occluded_columns = i < 5 ? 0 : 75 + static_cast<int>(76 * std::sin((i - 5) * 3.14159265 / 34));
    const ingest::Frame frame = render_frame({}, moving_pose(i), SE3::Identity(), i, options);
    const double hidden = 1 - label_pixels(frame) / whole;
    most_hidden = std::max(most_hidden, hidden);
    const auto result = tracker.track(frame);
    const Errors errors = error_of(result, first, moving_pose(i));
    if (hidden < (i < 22 ? 0.8 : 0.75)) expect_tracked(result, first, moving_pose(i), {0.004, 1.5}, i);
    if (result.pose.health != motion::Health::kTracked) continue;
    EXPECT_LT(errors.metres, 0.01) << "frame " << i << ", hidden " << hidden;
    EXPECT_LT(errors.degrees, 4) << "frame " << i << ", hidden " << hidden;
  }
  EXPECT_GT(most_hidden, 0.94);
}

// A plain rod may slide along itself, and the wall is out of the sensor's range: the label alone tells where it is not.
TEST(RigidScene, WhatStillShowsOfAThingThatSlipsBehindAnotherIsNotTakenForAllOfIt) {
  for (const double speed : {0.02, 0.03}) {
    SCOPED_TRACE(speed);
    const Shape rod{ShapeKind::kBox, {0.14, 0.03, 0.03}, false};
    const auto pose_of = [speed](int i) {
      const double gone = std::max(0, i - 5);
      return pose_at({0.2 - speed * gone, 0.02, 1}, 25, 20 - 4 * gone, 3 * gone);
    };
    RigidTracker tracker(2);
    for (int i = 0; i < 16; ++i) {
      SceneOptions options = noisy();
      options.occluded_columns = 110;
      ingest::Frame frame = render_frame(rod, pose_of(i), SE3::Identity(), i, options);
      for (std::size_t k = 0; k < frame.depth.pixel_count(); ++k) {
        if (frame.labels.values()[k] == 0) frame.depth.values()[k] = 0;
      }
      frame.clean_depth = frame.depth;
      const auto result = tracker.track(frame);
      if (result.pose.health != motion::Health::kTracked) continue;
      EXPECT_LT(error_of(result, pose_of(0), pose_of(i)).metres, 0.06) << "frame " << i;
    }
  }
}

TEST(RigidScene, IsFoundWhenItComesBackIntoView) {
  for (const bool textured : {true, false}) {
    SCOPED_TRACE(textured);
    RigidThing tracker(2);
    const Shape box{ShapeKind::kBox, {0.12, 0.09, 0.07}, textured};
    const auto pose_of = [](int i) { return pose_at({i < 12 ? 0.06 * i : 0.06 * (24 - i), 0, 1}, 20, 30 + i); };
    for (int i = 0; i < 24; ++i) {
      const auto result = tracker.track(render_frame(box, pose_of(i), SE3::Identity(), i, noisy()));
      if (i < 6 || i >= 19) expect_tracked(result, pose_of(0), pose_of(i), {0.006, 2.5}, i);
      if (i >= 12 && i < 14) {
        EXPECT_NE(result.pose.health, motion::Health::kTracked) << "frame " << i;
      }
    }
  }
}

/// Both shapes in one picture, the second with label 3.
ingest::Frame both(ingest::Frame a, const ingest::Frame& b) {
  for (std::size_t i = 0; i < a.labels.pixel_count(); ++i) {
    if (b.labels.values()[i] != 2 || (a.labels.values()[i] == 2 && a.depth.values()[i] < b.depth.values()[i])) continue;
    a.labels.values()[i] = 3;
    a.depth.values()[i] = b.depth.values()[i];
    std::copy_n(b.color.data() + 3 * i, 3, a.color.data() + 3 * i);
  }
  a.clean_depth = a.depth;
  return a;
}

TEST(RigidScene, TwoEqualThingsCrossAndStayThemselves) {
  RigidThing front(2);
  RigidThing behind(3);
  const auto front_pose = [](int i) { return pose_at({-0.2 + 0.016 * i, 0, 0.9}, 20, 30); };
  const auto behind_pose = [](int i) { return pose_at({0.2 - 0.016 * i, 0.02, 1.25}, 20, 30 + i); };
  for (int i = 0; i < 26; ++i) {
    const ingest::Frame frame = both(render_frame({}, front_pose(i), SE3::Identity(), i, noisy()),
                                     render_frame({}, behind_pose(i), SE3::Identity(), i + 100, noisy()));
    expect_tracked(front.track(frame), front_pose(0), front_pose(i), {0.004, 1.5}, i);
    const auto hidden = behind.track(frame);
    if (i < 5 || i > 20) {
      expect_tracked(hidden, behind_pose(0), behind_pose(i), {0.006, 2}, i);
    } else if (hidden.pose.health == motion::Health::kTracked) {
      EXPECT_LT(error_of(hidden, behind_pose(0), behind_pose(i)).metres, 0.015) << "frame " << i;
    }
  }
}

TEST(RigidScene, OneThingIsSetDownAndAnotherPickedUp) {
  RigidThing first(2);
  RigidThing second(3);
  const auto first_pose = [](int i) {
    return pose_at({-0.15, -0.01 * std::min(i, 8), 1}, 20, 30 + 2 * std::min(i, 8));
  };
  const auto second_pose = [](int i) {
    return pose_at({0.15, 0.01 * std::max(i, 8), 1.1}, 10, -20 + 2 * std::max(i, 8));
  };
  const Shape other{ShapeKind::kBox, {0.06, 0.1, 0.05}, true};
  for (int i = 0; i < 16; ++i) {
    const ingest::Frame frame = both(render_frame({}, first_pose(i), SE3::Identity(), i, noisy()),
                                     render_frame(other, second_pose(i), SE3::Identity(), i + 100, noisy()));
    expect_tracked(first.track(frame), first_pose(0), first_pose(i), {0.002, 1}, i);
    expect_tracked(second.track(frame), second_pose(0), second_pose(i), {0.002, 1}, i);
  }
}

TEST(RigidScene, IsHeldWhileDepthIsMissingOnAllOfIt) {
  RigidThing tracker(2);
  for (int i = 0; i < 24; ++i) {
    ingest::Frame frame = render_frame({}, moving_pose(i), SE3::Identity(), i, noisy());
    const bool glass = i >= 8 && i < 18;
    if (glass) {
      for (std::size_t k = 0; k < frame.labels.pixel_count(); ++k) {
        if (frame.labels.values()[k] == 2) frame.depth.values()[k] = 0;
      }
      frame.clean_depth = frame.depth;
    }
    const auto result = tracker.track(frame);
    if (glass) {
      EXPECT_EQ(result.pose.health, motion::Health::kHeld) << "frame " << i;
      EXPECT_EQ(result.pose.canonical_to_world.matrix(), tracker.poses()[7].canonical_to_world.matrix());
    } else {
      expect_tracked(result, moving_pose(0), moving_pose(i), {0.003, 1.5}, i);
    }
  }
}

TEST(RigidScene, BlackAndPlainThingsAreFollowedByTheirShape) {
  for (const double light : {0.0, 1.0}) {
    SCOPED_TRACE(light);
    SceneOptions options = noisy();
    options.light = light;
    RigidThing tracker(2);
    for (int i = 0; i < 16; ++i) {
      const Shape shape{ShapeKind::kBox, {0.12, 0.09, 0.07}, light == 0};
      const auto result = tracker.track(render_frame(shape, moving_pose(i), SE3::Identity(), i, options));
      expect_tracked(result, moving_pose(0), moving_pose(i), {0.005, 2}, i);
    }
  }
}

TEST(RigidScene, AHighlightThatStaysWhileTheThingTurnsMisleadsLittle) {
  RigidThing tracker(2);
  for (int i = 0; i < 16; ++i) {
    ingest::Frame frame = render_frame({}, moving_pose(i), SE3::Identity(), i, noisy());
    for (int v = 70; v < 100; ++v) {
      for (int u = 100; u < 135; ++u) {
        if (frame.labels.at(u, v) != 2) continue;
        for (int c = 0; c < 3; ++c) frame.color.at(u, v, c) = 255;
      }
    }
    expect_tracked(tracker.track(frame), moving_pose(0), moving_pose(i), {0.004, 1.5}, i);
  }
}

TEST(RigidScene, ThreeTimesTheNoiseBendsNothing) {
  SceneOptions options;
  options.noise = 3;
  for (const ShapeKind kind : {ShapeKind::kBox, ShapeKind::kSphere, ShapeKind::kCylinder, ShapeKind::kPlane}) {
    SCOPED_TRACE(static_cast<int>(kind));
    RigidThing tracker(2);
    for (int i = 0; i < 16; ++i) {
      tracker.track(render_frame({kind, {0.12, 0.09, 0.07}, true}, moving_pose(i), SE3::Identity(), i, options));
    }
  }
}

TEST(RigidScene, LightThatIsHalvedMovesNothing) {
  RigidThing tracker(2);
  for (int i = 0; i < 16; ++i) {
    SceneOptions options = noisy();
    options.light = i < 8 ? 1 : 0.5;
    const auto result = tracker.track(render_frame({}, moving_pose(i), SE3::Identity(), i, options));
    expect_tracked(result, moving_pose(0), moving_pose(i), {0.002, 1}, i);
  }
}

TEST(RigidScene, OneThreadAndTwoGiveTheSameBitsAcrossAJump) {
  std::vector<std::vector<motion::Motion::Pose>> runs;
  for (const int threads : {1, 2}) {
    set_thread_count(threads);
    RigidThing tracker(2);
    for (int i = 0; i < 10; ++i) {
      const SE3 jump = i < 5 ? SE3::Identity() : pose_at({0.15, -0.05, 0.1}, 0, 0);
      const SE3 pose = jump * moving_pose(i) * pose_at({0, 0, 0}, 0, i < 5 ? 0 : 35);
      tracker.track(render_frame({}, pose, SE3::Identity(), i, noisy()));
    }
    runs.push_back(tracker.poses());
  }
  set_thread_count(0);
  for (std::size_t i = 0; i < runs[0].size(); ++i) {
    EXPECT_EQ(runs[0][i].canonical_to_world.matrix(), runs[1][i].canonical_to_world.matrix()) << "frame " << i;
    EXPECT_EQ(runs[0][i].health, runs[1][i].health);
  }
}

} // namespace
} // namespace kinora::tracking
