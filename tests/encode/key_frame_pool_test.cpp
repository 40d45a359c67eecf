// Which frames live training keeps, and which it takes for a view.
#include "encode/live/key_frame_pool.h"

#include <algorithm>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "encode/live/blurriness.h"
#include "encode/live/live_exchange.h"
#include "tracking/scenes/synthetic_scene.h"

namespace kinora::encode {
namespace {

constexpr int kBox = 2; ///< the label of the box

/// A box that stands in some pose in each frame, before a still camera, with what is known of it.
struct TurningBox {
  std::vector<KeyFrame> frames;
  LiveSnapshot snapshot;

  explicit TurningBox(const std::vector<double>& degrees) {
    std::vector<motion::Motion::Pose> poses;
    const SE3 first = tracking::testing::pose_at({0, 0, 1}, 15, degrees.front());
    for (std::size_t i = 0; i < degrees.size(); ++i) {
      const SE3 pose = tracking::testing::pose_at({0, 0, 1}, 15, degrees[i]);
      const int number = static_cast<int>(i);
      frames.push_back({number, std::make_shared<const ingest::Frame>(
                                    tracking::testing::render_frame({}, pose, SE3::Identity(), number))});
      poses.push_back({pose * first.inverse(), motion::Health::kTracked});
      snapshot.timeline.times.push_back(frames.back().frame->time);
    }
    snapshot.labels.emplace(kBox, LabelSnapshot{"object", motion::Motion::rigid(std::move(poses)), std::nullopt});
  }

  KeyFramePool pool(const KeyFrameConfig& config) const {
    KeyFramePool pool(config);
    for (const KeyFrame& frame : frames) pool.add(frame, snapshot);
    return pool;
  }
};

/// Sixty frames in which the box shows one side, but for a moment in which it shows the others.
std::vector<double> mostly_still() {
  std::vector<double> degrees(60, 10);
  for (std::size_t i = 0; i < 4; ++i) degrees[25 + i] = 10 + 90 * static_cast<double>(i + 1);
  return degrees;
}

std::vector<int> numbers_of(const std::vector<KeyFrame>& frames) {
  std::vector<int> numbers;
  numbers.reserve(frames.size());
  for (const KeyFrame& frame : frames) numbers.push_back(frame.number);
  return numbers;
}

KeyFrameConfig config_of(KeyFrameRule rule, std::size_t capacity) {
  KeyFrameConfig config;
  config.rule = rule;
  config.capacity = capacity;
  return config;
}

constexpr std::array kRules{KeyFrameRule::kInterval, KeyFrameRule::kPaper, KeyFrameRule::kCoverage};

ingest::Frame blurred(const ingest::Frame& frame, int reach) {
  ingest::Frame out = frame;
  for (int v = 0; v < frame.color.height(); ++v) {
    for (int u = 0; u < frame.color.width(); ++u) {
      for (int c = 0; c < 3; ++c) {
        int sum = 0;
        for (int d = -reach; d <= reach; ++d)
          sum += frame.color.at(std::clamp(u + d, 0, frame.color.width() - 1), v, c);
        out.color.at(u, v, c) = static_cast<std::uint8_t>(sum / (2 * reach + 1));
      }
    }
  }
  return out;
}

TEST(Blurriness, GrowsAsAPictureIsBlurredAlongOneDirection) {
  const ingest::Frame sharp =
      tracking::testing::render_frame({}, tracking::testing::pose_at({0, 0, 0.6}, 15, 20), SE3::Identity(), 0);
  double last = blurriness(sharp).value();
  EXPECT_GT(last, 0);
  for (const int reach : {1, 2, 4, 6}) {
    const double now = blurriness(blurred(sharp, reach)).value();
    EXPECT_GT(now, last + 0.02) << reach;
    last = now;
  }
  EXPECT_LE(last, 1);
}

TEST(Blurriness, LooksAtWhatIsLabelledAlone) {
  const ingest::Frame sharp =
      tracking::testing::render_frame({}, tracking::testing::pose_at({0, 0, 0.6}, 15, 20), SE3::Identity(), 0);
  ingest::Frame mixed = blurred(sharp, 5);
  for (int v = 0; v < sharp.color.height(); ++v) {
    for (int u = 0; u < sharp.color.width(); ++u) {
      // what a difference of means looks at, too
      bool is_near = false;
      for (int d = -6; d <= 6; ++d) {
        is_near |= sharp.labels.contains(u + d, v) && sharp.labels.at(u + d, v) != 0;
        is_near |= sharp.labels.contains(u, v + d) && sharp.labels.at(u, v + d) != 0;
      }
      if (is_near) std::copy_n(sharp.color.pixel(u, v), 3, mixed.color.pixel(u, v));
    }
  }
  EXPECT_EQ(blurriness(mixed), blurriness(sharp));
}

TEST(Blurriness, SaysNothingOfAFewPixels) {
  ingest::Frame frame;
  EXPECT_EQ(blurriness(frame), std::nullopt);
  frame.color = ColorImage(20, 20, 3);
  EXPECT_EQ(blurriness(frame), std::nullopt);
  frame.color = ColorImage(100, 100, 3, 77); // all alike: nothing is sharp there
  EXPECT_EQ(blurriness(frame), 1);
}

TEST(KeyFramePool, LeavesOutAFrameThatIsBlurredAmongSharpOnes) {
  TurningBox box(std::vector<double>(12, 20));
  box.frames[9].frame = std::make_shared<const ingest::Frame>(blurred(*box.frames[9].frame, 5));
  for (const KeyFrameRule rule : kRules) {
    const KeyFramePool pool = box.pool(config_of(rule, 20));
    EXPECT_EQ(pool.blurred(), 1U);
    EXPECT_FALSE(std::ranges::count(numbers_of(pool.frames()), 9));
  }
}

TEST(KeyFramePool, KeepsFramesThatAreAllBlurred) {
  TurningBox box(std::vector<double>(12, 20));
  for (KeyFrame& frame : box.frames) frame.frame = std::make_shared<const ingest::Frame>(blurred(*frame.frame, 5));
  EXPECT_EQ(box.pool(config_of(KeyFrameRule::kInterval, 20)).frames().size(), 12U);
}

TEST(KeyFramePool, HasNoMoreThanItsRoomInOrderWithTheNewest) {
  std::mt19937 generator(5);
  std::uniform_real_distribution<double> angle(0, 360);
  std::vector<double> degrees;
  degrees.reserve(40);
  for (int i = 0; i < 40; ++i) degrees.push_back(angle(generator));
  const TurningBox box(degrees);
  for (const KeyFrameRule rule : kRules) {
    for (const std::size_t capacity : {0U, 2U, 3U, 8U, 100U}) {
      KeyFramePool pool(config_of(rule, capacity));
      EXPECT_TRUE(pool.frames().empty());
      for (const KeyFrame& frame : box.frames) {
        pool.add(frame, box.snapshot);
        const std::vector<int> numbers = numbers_of(pool.frames());
        ASSERT_LE(numbers.size(), std::max<std::size_t>(capacity, 2));
        ASSERT_TRUE(std::ranges::is_sorted(numbers));
        ASSERT_EQ(numbers.back(), frame.number);
      }
    }
  }
}

TEST(KeyFramePool, OfAnIntervalIsSpreadOverLongCaptures) {
  KeyFramePool pool(config_of(KeyFrameRule::kInterval, 8));
  for (int i = 0; i < 1000; ++i) pool.add({i, std::make_shared<ingest::Frame>()}, {});
  const std::vector<int> numbers = numbers_of(pool.frames());
  EXPECT_EQ(numbers.front(), 0);
  for (std::size_t i = 1; i < numbers.size(); ++i) EXPECT_LE(numbers[i] - numbers[i - 1], 1000 / 3) << i;
}

TEST(KeyFramePool, OfCoverageKeepsTheSidesThatWereSeenForAMoment) {
  const TurningBox box(mostly_still());
  const std::vector<int> numbers = numbers_of(box.pool(config_of(KeyFrameRule::kCoverage, 8)).frames());
  for (int i = 25; i < 28; ++i) EXPECT_EQ(std::ranges::count(numbers, i), 1) << i; // 28 shows what all others show
  EXPECT_GT(numbers[numbers.size() - 2] - numbers[0], 30);                         // the others are spread
  const std::vector<int> even = numbers_of(box.pool(config_of(KeyFrameRule::kInterval, 8)).frames());
  EXPECT_LT(std::ranges::count_if(even, [](int i) { return i >= 25 && i < 28; }), 3);
}

TEST(KeyFramePool, OfTheViewsOfAStillSceneKeepsSomeOfAllTimes) {
  const TurningBox box(std::vector<double>(60, 20));
  const std::vector<int> numbers = numbers_of(box.pool(config_of(KeyFrameRule::kCoverage, 7)).frames());
  EXPECT_EQ(numbers.front(), 0);
  for (std::size_t i = 1; i < numbers.size(); ++i) EXPECT_LE(numbers[i] - numbers[i - 1], 24) << i;
}

TEST(KeyFramePool, TakesForAViewTheFramesThatShowThatSideAndTheNewest) {
  std::vector<double> degrees;
  degrees.reserve(40);
  for (int i = 0; i < 36; ++i) degrees.push_back(10.0 * i); // once around
  degrees.insert(degrees.end(), 4, 0.0);
  const TurningBox box(degrees);
  KeyFrameConfig config = config_of(KeyFrameRule::kCoverage, 100);
  config.similar = 4;
  const KeyFramePool pool = box.pool(config);
  for (const double aside : {0.0, 70.0, 180.0, 250.0}) {
    // a camera that goes about the box, which has turned back, sees what this one saw when the box was turned
    const double a = aside * std::numbers::pi / 180;
    SE3 camera = SE3::Identity();
    camera.translation() = Eigen::Vector3d(std::sin(a), 0, 1 - std::cos(a));
    std::vector<int> numbers = numbers_of(pool.frames_for(camera, box.snapshot));
    ASSERT_LE(numbers.size(), 8U);
    for (int newest = 36; newest < 40; ++newest) ASSERT_EQ(std::ranges::count(numbers, newest), 1);
    for (const int number : numbers) {
      if (number >= 36) continue;
      const double apart = std::abs(std::remainder(degrees[static_cast<std::size_t>(number)] - aside, 360));
      EXPECT_LE(apart, 35) << "frame " << number << " for " << aside << " degrees";
    }
  }
}

TEST(KeyFramePool, IsNotMisledByALayerThatIsLostOrNotMeasured) {
  TurningBox box(mostly_still());
  std::vector<motion::Motion::Pose> lost(60);
  for (auto& pose : lost) pose.health = motion::Health::kLost;
  box.snapshot.labels.emplace(7, LabelSnapshot{"lost", motion::Motion::rigid(lost), std::nullopt});
  box.snapshot.labels.emplace(9, LabelSnapshot{"unseen", motion::Motion::still(), std::nullopt});
  for (const KeyFrameRule rule : kRules) {
    const KeyFramePool pool = box.pool(config_of(rule, 8));
    EXPECT_LE(pool.frames().size(), 8U);
    EXPECT_FALSE(pool.frames_for(SE3::Identity(), box.snapshot).empty());
  }
}

TEST(LayerLooks, OfABendingLayerAreThoseOfItsNodes) {
  const TurningBox box({20, 60});
  const std::vector<Eigen::Vector3d> nodes{{-0.1, 0, 0.95}, {0.1, 0, 0.95}, {0, 0, 5}};
  auto graph = std::make_shared<motion::DeformationGraph>(nodes, 0.1, 0.3);
  std::vector<motion::Motion::Deformation> deformations(2);
  SE3 turned = SE3::Identity();
  turned.linear() = Eigen::AngleAxisd(1, Eigen::Vector3d::UnitY()).toRotationMatrix();
  for (const Eigen::Vector3d& node : nodes) {
    deformations[0].node_to_world.push_back(DualQuaternion());
    // turned where it is
    deformations[1].node_to_world.push_back(
        DualQuaternion::from(SE3(Eigen::Translation3d(node) * turned * Eigen::Translation3d(-node))));
  }
  const motion::Motion motion = motion::Motion::deforming(graph, deformations);
  const auto before = looks_of(*box.frames[0].frame, kBox, motion, 0, {});
  ASSERT_EQ(before.size(), 2U); // the third is far behind
  EXPECT_EQ(before[0].place, 0U);
  EXPECT_EQ(before[1].place, 1U);
  EXPECT_GT(before[0].towards_camera.dot(Eigen::Vector3f(0, 0, -1)), 0.95F);
  const auto after = looks_of(*box.frames[1].frame, kBox, motion, 1, {});
  ASSERT_EQ(after.size(), 2U);
  const Eigen::Vector3f turned_back = (turned.linear().transpose() * Eigen::Vector3d(0, 0, -1)).cast<float>();
  EXPECT_GT(after[0].towards_camera.dot(turned_back), 0.95F);
  EXPECT_GT(similarity(before, looks_from(Eigen::Vector3d::Zero(), before, motion, 0, {})), 0.95);
  EXPECT_NEAR(similarity(before, looks_from(Eigen::Vector3d::Zero(), before, motion, 1, {})),
              std::pow(std::cos(1.0), 2), 0.1);
  EXPECT_EQ(similarity(before, looks_from(Eigen::Vector3d(0, 0, 9), before, motion, 0, {})), 0);
}

TEST(PaperDistance, IsThatOfTheEquations) {
  PaperView a;
  PaperView b;
  b.translation = {3, 4, 0};
  EXPECT_DOUBLE_EQ(paper_distance(a, b, 10), 25 + 0.02 * 100);
  const Eigen::Quaterniond turned(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitX()));
  a.visible = {true, false, true, true};
  a.rotations.assign(4, Eigen::Quaterniond::Identity());
  b.visible = {false, true, true, true, true}; // one node more
  b.rotations.assign(5, Eigen::Quaterniond::Identity());
  b.rotations[3] = turned;
  EXPECT_NEAR(paper_distance(a, b, -5), 1.12 * 0.25 / 4 + 0.01 * 2 + 0.02 * 25, 1e-12);
}

TEST(PaperDistance, SeesANodeWhereTheDepthIsItsOwn) {
  const TurningBox box({20});
  ingest::Frame frame = *box.frames[0].frame;
  std::ranges::fill(frame.depth.values(), 1.0F);
  const std::vector<Eigen::Vector3d> nodes{{0, 0, 1.005}, {0, 0, 1.02}, {0, 0, -1}, {50, 0, 1}};
  auto graph = std::make_shared<motion::DeformationGraph>(nodes, 0.1, 0.3);
  const motion::Motion motion = motion::Motion::deforming(graph, {{std::vector<DualQuaternion>(4), {}}});
  EXPECT_EQ(paper_view(frame, motion, 0).visible, (std::vector<bool>{true, false, false, false}));
}

TEST(LiveExchange, ForgetsEveryOtherFrameThatNobodyTakes) {
  LiveExchange exchange;
  for (int i = 0; i < 100; ++i) exchange.show({i, nullptr});
  const std::vector<int> early = numbers_of(exchange.take_frames(60));
  ASSERT_FALSE(early.empty());
  EXPECT_EQ(early.front(), 0);
  EXPECT_LT(early.back(), 60);
  const std::vector<int> late = numbers_of(exchange.take_frames(1000));
  EXPECT_EQ(late.back(), 99);
  EXPECT_LE(early.size() + late.size(), 16U);
  EXPECT_TRUE(exchange.take_frames(1000).empty());
}

} // namespace
} // namespace kinora::encode
