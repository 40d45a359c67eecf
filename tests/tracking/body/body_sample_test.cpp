// The sample's person, whose left arm is hidden by the box at first and then waves.
#include <gtest/gtest.h>

#include "host/plugin_table.h"
#include "ingest/capture/capture.h"
#include "support/source_folder.h"
#include "tracking/body/body_tracker.h"
#include "tracking/body/true_joints.h"
#include "tracking/view/deforming_view.h"

namespace kinora::tracking {
namespace {

TEST(BodySample, WristsAreFollowedWhileTheyAreSeen) {
  const std::string sample = (test::source_folder() / "samples/carry_box").string();
  const testing::TrueJoints truth = testing::read_true_joints(sample);
  ASSERT_EQ(truth.size(), 55U);
  Progress silent;
  const auto capture = ingest::Capture::open(host::PluginTable::builtin(), sample, {}, silent);
  BodyTracker tracker;
  while (const auto frame = capture->next()) {
    const int i = frame->index;
    const auto result = tracker.track(view_layer(*frame, 1), frame->camera.camera_to_world, frame->time);
    EXPECT_EQ(result.health, motion::Health::kTracked) << i;
    const Bones bones = forward_kinematics(tracker.state().pose, tracker.state().shape);
    const auto error = [&](Joint joint, const char* name) {
      return (bones[joint].translation() - truth.at(i).at(name)).norm();
    };
    // The rig's joints are up to 4 cm from ours.
    EXPECT_LT(error(kHead, "head"), 0.06) << i;
    EXPECT_LT(error(kLeftKnee, "calf_l"), 0.06) << i;
    if (i <= 38) {
      EXPECT_LT(error(kRightWrist, "hand_r"), 0.08) << i;
    } else if (i >= 42) {
      EXPECT_LT(error(kLeftWrist, "hand_l"), 0.08) << i;
    }
    EXPECT_LT(error(kLeftElbow, "lowerarm_l"), 0.12) << i; // hidden in frames 10 to 38
  }
}

} // namespace
} // namespace kinora::tracking
