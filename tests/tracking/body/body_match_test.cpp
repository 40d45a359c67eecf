#include "tracking/body/body_match.h"

#include "core/random.h"
#include "support/every_instruction_set.h"

namespace kinora::tracking {
namespace {

class BodyMatchTest : public OnEveryInstructionSet {};

TEST_P(BodyMatchTest, IsThatOfEachPointAlone) {
  constexpr double kNormalLength = 0.05;
  Random random(9);
  BodyState state{rest_pose(), Shape::Zero()};
  state.pose.root.translation() = Eigen::Vector3d(0.2, 0.1, 2.5);
  const BodyInCamera body(state);
  std::vector<MeasuredPoint> points;
  for (const BodySample& sample : body_samples()) {
    const SE3& bone = body.bone(sample.part);
    const PartShape& part = body.body().parts[sample.part];
    const auto noise = [&](double size) {
      return Eigen::Vector3d(size * random.normal(), size * random.normal(), size * random.normal());
    };
    points.push_back({bone * position_of(part, sample.point) + noise(0.03),
                      (bone.linear() * normal_of(part, sample.point) + noise(0.3)).normalized(), 1});
  }
  points.resize(points.size() - points.size() % 16 + 5);
  for (const double max_cost : {1e9, 0.02 * 0.02}) {
    std::vector<PartMatch> matches(points.size());
    match_points(body, points, kNormalLength, max_cost, matches);
    int none = 0;
    for (std::size_t p = 0; p < points.size(); ++p) {
      BodyInCamera::Match best(max_cost);
      for (std::size_t part = 0; part < kBodyParts; ++part) body.match(part, points[p], kNormalLength, best);
      none += best.part < 0 ? 1 : 0;
      EXPECT_NEAR(matches[p].cost, best.cost, 2e-6 + 1e-6 * best.cost) << p;
      if (matches[p].part == best.part) continue;
      // Two parts that explain the point alike, or one that hardly does.
      BodyInCamera::Match found(max_cost + 1e-6);
      if (matches[p].part >= 0) body.match(static_cast<std::size_t>(matches[p].part), points[p], kNormalLength, found);
      EXPECT_NEAR(found.cost, best.cost, 2e-6) << p;
    }
    EXPECT_LT(none, static_cast<int>(points.size()) * 9 / 10);
    if (max_cost < 1) {
      EXPECT_GT(none, 20);
    }
  }
}

TEST_P(BodyMatchTest, LeavesOutPartsThatAreNotInQuestion) {
  BodyState state{rest_pose(), Shape::Zero()};
  state.pose.root.translation() = Eigen::Vector3d(0, 0, 2);
  const BodyInCamera body(state);
  const BodySample& sample = body_samples().front();
  const SE3& bone = body.bone(sample.part);
  const PartShape& shape = body.body().parts[sample.part];
  const std::vector<MeasuredPoint> points(
      3, {bone * position_of(shape, sample.point), bone.linear() * normal_of(shape, sample.point), 1});
  std::array<bool, kBodyParts> others;
  others.fill(true);
  std::vector<PartMatch> matches(points.size());
  match_points(body, points, 0.05, 1, others, matches);
  EXPECT_EQ(matches[2].part, static_cast<int>(sample.part));
  others[sample.part] = false;
  match_points(body, points, 0.05, 1, others, matches);
  EXPECT_NE(matches[2].part, static_cast<int>(sample.part));
}

INSTANTIATE_TEST_SUITE_P(Sets, BodyMatchTest, every_instruction_set(), name_of_set);

} // namespace
} // namespace kinora::tracking
