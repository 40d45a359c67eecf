// A person, or an arm, that is elsewhere from one frame to the next. All sizes:
// docs/experiments/curves/tracking_basin.svg.
#include <numeric>
#include <string>

#include <gtest/gtest.h>

#include "core/parallel.h"
#include "tracking/body/person_jumps.h"
#include "tracking/deforming/deforming_tracker.h"

namespace kinora::tracking {
namespace {

using testing::Jump;

testing::PersonCamera camera_of(std::uint64_t trial) { return {480, 360, 393.75, trial}; }
constexpr int kTrials = 6;

struct Case {
  const char* name;
  Jump jump;
  double size;  ///< metres or degrees
  double bound; ///< metres, of the mean error of what jumped, four frames later
  int least;    ///< trials that keep to it
};

motion::Motion follow(const testing::PersonScene& scene, const testing::PersonCamera& camera) {
  DeformingTracker tracker(1);
  for (int i = 0; i < scene.frames; ++i) tracker.track(testing::see_person(scene, i, camera));
  return tracker.motion();
}

double mean_error(Jump jump, double size, std::uint64_t trial) {
  const testing::PersonCamera camera = camera_of(trial);
  const testing::PersonScene scene = testing::jumping_person(jump, size, trial);
  const auto errors = testing::errors_after_jump(scene, follow(scene, camera), testing::kJumpFrames,
                                                 testing::kJumpFrames - 1, camera, 2000);
  return std::accumulate(errors.begin(), errors.end(), 0.0) / static_cast<double>(errors.size());
}

class JumpingPersons : public ::testing::TestWithParam<Case> {};

TEST_P(JumpingPersons, IsFound) {
  int found = 0;
  for (std::uint64_t trial = 0; trial < kTrials; ++trial) {
    if (mean_error(GetParam().jump, GetParam().size, trial) < GetParam().bound) ++found;
  }
  EXPECT_GE(found, GetParam().least);
}

INSTANTIATE_TEST_SUITE_P(Jumps, JumpingPersons,
                         ::testing::Values(Case{"person30Centimetres", Jump::kPersonShift, 0.30, 0.010, kTrials},
                                           Case{"person30Degrees", Jump::kPersonRotation, 30, 0.010, kTrials},
                                           Case{"hand5Centimetres", Jump::kHandShift, 0.05, 0.010, kTrials},
                                           Case{"hand20Centimetres", Jump::kHandShift, 0.20, 0.030, 4},
                                           Case{"forearm15Degrees", Jump::kForearmRotation, 15, 0.010, kTrials},
                                           Case{"forearm40Degrees", Jump::kForearmRotation, 40, 0.040, 5}),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(JumpingPerson, EndsWithTheSameBitsOnOneThreadAndTwo) {
  const auto scene = testing::jumping_person(Jump::kPersonShift, 0.30, 1);
  std::vector<motion::Motion> motions;
  for (const int threads : {1, 2}) {
    set_thread_count(threads);
    motions.push_back(follow(scene, camera_of(1)));
  }
  set_thread_count(0);
  ASSERT_EQ(motions[0].graph()->nodes(), motions[1].graph()->nodes());
  for (std::size_t f = 0; f < testing::kJumpFrames; ++f) {
    for (std::size_t i = 0; i < motions[0].graph()->nodes().size(); ++i) {
      const DualQuaternion& one = motions[0].deformations()[f].node_to_world[i];
      const DualQuaternion& two = motions[1].deformations()[f].node_to_world[i];
      ASSERT_EQ(one.real.coeffs(), two.real.coeffs()) << f;
      ASSERT_EQ(one.dual.coeffs(), two.dual.coeffs()) << f;
    }
  }
}

} // namespace
} // namespace kinora::tracking
