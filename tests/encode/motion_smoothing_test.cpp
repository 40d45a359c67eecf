// Claims about smoothing a deforming motion in time.
#include "encode/motion_smoothing.h"

#include <cmath>
#include <functional>
#include <memory>

#include <gtest/gtest.h>

#include "core/random.h"
#include "core/se3.h"

namespace kinora::encode {
namespace {

using motion::Health;
using Deformations = std::vector<motion::Motion::Deformation>;

const std::vector<Eigen::Vector3d> kNodes{{0, 0, 2}, {0.1, -0.3, 2.5}, {1, 1, 1}};
constexpr std::size_t kFrames = 60;

/// Nodes that all move as `pose_at` says.
Deformations motion_of(const std::function<SE3(double frame)>& pose_at) {
  Deformations deformations(kFrames);
  for (std::size_t f = 0; f < kFrames; ++f) {
    deformations[f].node_to_world.assign(kNodes.size(), DualQuaternion::from(pose_at(static_cast<double>(f))));
  }
  return deformations;
}

SE3 swing(double frame) {
  Twist twist;
  twist << 0.3, 0.1 * frame / 30, -0.2 * (frame / 30) * (frame / 30), 0.02 * frame, 0, 0.3;
  return exp_se3(twist);
}

Deformations smoothed(const Deformations& deformations) {
  const auto graph = std::make_shared<const motion::DeformationGraph>(kNodes, 0.1, 0.3);
  return smoothed_in_time(motion::Motion::deforming(graph, deformations)).deformations();
}

Eigen::Vector3d place(const Deformations& deformations, std::size_t f, std::size_t n) {
  return deformations[f].node_to_world[n].to_se3() * kNodes[n];
}

/// Root mean square distance of the nodes from where they are in `truth`, metres.
double error(const Deformations& deformations, const Deformations& truth) {
  double sum = 0;
  for (std::size_t f = 0; f < kFrames; ++f) {
    for (std::size_t n = 0; n < kNodes.size(); ++n)
      sum += (place(deformations, f, n) - place(truth, f, n)).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(kFrames * kNodes.size()));
}

bool same_nodes(const motion::Motion::Deformation& a, const motion::Motion::Deformation& b) {
  for (std::size_t n = 0; n < kNodes.size(); ++n) {
    const DualQuaternion& p = a.node_to_world[n];
    const DualQuaternion& q = b.node_to_world[n];
    if (p.real.coeffs() != q.real.coeffs() || p.dual.coeffs() != q.dual.coeffs()) return false;
  }
  return true;
}

TEST(MotionSmoothing, LeavesAMotionAloneThatIsSmooth) {
  const Deformations truth = motion_of(swing);
  const Deformations smooth = smoothed(truth);
  EXPECT_LT(error(smooth, truth), 1e-4);
}

TEST(MotionSmoothing, TakesOutTwoFifthsOfATremble) {
  const Deformations truth = motion_of(swing);
  for (const std::uint64_t seed : {1, 2, 3}) {
    Random random(seed);
    Deformations trembling = truth;
    for (auto& deformation : trembling) {
      for (DualQuaternion& node : deformation.node_to_world) {
        Twist tremble;
        for (int i = 0; i < 6; ++i) tremble[i] = random.normal() * 5e-4;
        node = DualQuaternion::from(exp_se3(tremble) * node.to_se3());
      }
    }
    const Deformations smooth = smoothed(trembling);
    EXPECT_LT(error(smooth, truth), 0.6 * error(trembling, truth)); // √(59/231) = 0.51, more at both ends
  }
}

TEST(MotionSmoothing, MovesNoNodeByMoreThanHalfOfATrackersErrorHoweverAMotionChanges) {
  for (const double step : {0.003, 0.01, 0.03, 0.1, 0.3, 3.0}) { // metres a frame, at once
    const Deformations truth = motion_of([step](double frame) {
      SE3 pose = SE3::Identity();
      pose.translation().x() = frame < 30 ? 0 : step * (frame - 30);
      return pose;
    });
    const Deformations smooth = smoothed(truth);
    for (std::size_t f = 0; f < kFrames; ++f) {
      EXPECT_LE((place(smooth, f, 0) - place(truth, f, 0)).norm(), 0.0025 + 1e-9) << step << " " << f;
    }
  }
}

TEST(MotionSmoothing, LeavesFramesAloneThatAreNotInARowOfNineTrackedOnes) {
  Deformations rough = motion_of(swing);
  for (std::size_t f = 0; f < kFrames; f += 2) {
    for (DualQuaternion& node : rough[f].node_to_world) {
      node = DualQuaternion::from(SE3(Eigen::Translation3d(0.001, 0, 0)) * node.to_se3());
    }
  }
  rough[20].health = Health::kHeld;
  rough[29].health = Health::kLost; // eight between them
  rough[39].health = Health::kHeld; // nine
  const Deformations smooth = smoothed(rough);
  for (std::size_t f = 0; f < kFrames; ++f) {
    const bool alone = (f >= 20 && f <= 29) || f == 39;
    EXPECT_EQ(same_nodes(smooth[f], rough[f]), alone) << f;
    EXPECT_EQ(smooth[f].health, rough[f].health);
  }
}

TEST(MotionSmoothing, KeepsApartWhatALostFrameParts) {
  const Deformations truth = motion_of([](double frame) { // a jump while nothing was seen
    SE3 pose = SE3::Identity();
    pose.translation().x() = frame < 30 ? 0 : 0.002;
    return pose;
  });
  Deformations rough = truth;
  rough[30].health = Health::kLost;
  const Deformations smooth = smoothed(rough);
  for (std::size_t f = 0; f < kFrames; ++f)
    EXPECT_NEAR((place(smooth, f, 0) - place(truth, f, 0)).norm(), 0, 1e-9) << f;
}

TEST(MotionSmoothing, ShortMotionsStayAsTheyAre) {
  for (const std::size_t frames : {1U, 2U, 8U}) {
    Deformations rough = motion_of(swing);
    rough.resize(frames);
    const Deformations smooth = smoothed(rough);
    for (std::size_t f = 0; f < frames; ++f) EXPECT_TRUE(same_nodes(smooth[f], rough[f])) << f;
  }
}

} // namespace
} // namespace kinora::encode
