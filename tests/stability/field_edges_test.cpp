// A red ball before a green wall, where depth is wrong beside the ball's edge: how much of the one's colour is drawn
// where the other one is. Depth is cleaned as that of every capture is.
#include <functional>

#include <gtest/gtest.h>

#include "fields/rendering/renderer.h"
#include "fields/scenes/analytic_scene.h"
#include "ingest/depth/depth_cleaning.h"

namespace kinora::fields {
namespace {

constexpr int kBall = 2;
constexpr int kFrames = 12;
constexpr int kContour = 3; // pixels
const Eigen::Vector3d kRed(220, 40, 40);
const Eigen::Vector3d kGreen(40, 200, 60);

ingest::Frame red_ball(int index, double angle) {
  ingest::Frame frame = Scene{}.frame(index, angle);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const Eigen::Vector3d& rgb = frame.labels.at(u, v) == kBall ? kRed : kGreen;
      for (int c = 0; c < 3; ++c) frame.color.at(u, v, c) = static_cast<std::uint8_t>(rgb[c]);
    }
  }
  return frame;
}

/// Calls visit(u, v) for the pixels of the image not farther than `radius` from one.
template <class Visit> void for_each_near(int u, int v, int radius, const Visit& visit) {
  for (int y = std::max(v - radius, 0); y <= std::min(v + radius, kHeight - 1); ++y) {
    for (int x = std::max(u - radius, 0); x <= std::min(u + radius, kWidth - 1); ++x) {
      if ((x - u) * (x - u) + (y - v) * (y - v) <= radius * radius) visit(x, y);
    }
  }
}

using Change = std::function<void(ingest::Frame&)>;

/// Depths beside an edge become `choose(least, most)` of those within `radius` pixels.
Change depth_from_near(int radius, const std::function<float(float, float)>& choose) {
  return [=](ingest::Frame& frame) {
    const DepthImage there = frame.depth;
    for (int v = 0; v < kHeight; ++v) {
      for (int u = 0; u < kWidth; ++u) {
        float least = there.at(u, v);
        float most = least;
        for_each_near(u, v, radius, [&](int x, int y) {
          least = std::min(least, there.at(x, y));
          most = std::max(most, there.at(x, y));
        });
        constexpr float kEdge = 0.3F;
        if (most - least > kEdge) frame.depth.at(u, v) = choose(least, most);
      }
    }
  };
}

void displace(ingest::Frame& frame) {
  const DepthImage there = frame.depth;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) frame.depth.at(u, v) = there.at(std::min(u + 2, kWidth - 1), v);
  }
}

void let_fly(ingest::Frame& frame) {
  Random random(33, static_cast<std::uint64_t>(frame.index));
  depth_from_near(1, [&random](float least, float most) { return least + random.uniform() * (most - least); })(frame);
}

struct EdgeCase {
  const char* name;
  Change disturb;
};

const EdgeCase kExact{"Exact", [](ingest::Frame&) {}};
const EdgeCase kDisplaced{"DisplacedByTwoPixels", displace};
const EdgeCase kTooFarOut{"TwoPixelsTooFarOut", depth_from_near(2, [](float least, float) { return least; })};
const EdgeCase kTooFarIn{"TwoPixelsTooFarIn", depth_from_near(2, [](float, float most) { return most; })};
const EdgeCase kFlying{"WithFlyingPixels", let_fly};

/// Shares of the other one's colour: 0 none, 1 all.
struct Bleeding {
  double into_ball = 0; ///< mean over what is nearer to the wall than kContour
  double into_wall = 0; ///< and the other way round
  double beyond = 0;    ///< mean elsewhere
};

Bleeding bleeding(const Picture& picture, const ingest::Frame& truth) {
  Bleeding result;
  int ball_contour = 0;
  int wall_contour = 0;
  int others = 0;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const bool ball = truth.labels.at(u, v) == kBall;
      bool contour = false;
      for_each_near(u, v, kContour,
                    [&](int x, int y) { contour = contour || (truth.labels.at(x, y) == kBall) != ball; });
      const std::uint8_t* drawn = picture.color.pixel(u, v);
      const Eigen::Vector3d own = ball ? kRed : kGreen;
      const Eigen::Vector3d way = (ball ? kGreen : kRed) - own;
      const double share = (Eigen::Vector3d(drawn[0], drawn[1], drawn[2]) - own).dot(way) / way.squaredNorm();
      if (!contour) {
        result.beyond += share;
        ++others;
      } else {
        (ball ? result.into_ball : result.into_wall) += share;
        ++(ball ? ball_contour : wall_contour);
      }
    }
  }
  result.into_ball /= ball_contour;
  result.into_wall /= wall_contour;
  result.beyond /= others;
  return result;
}

/// Draws ball and wall after training, as a layer each or as a single one.
Bleeding learn(const Change& disturb, const std::vector<int>& labels) {
  PixelStore store(1'000'000, kFrames);
  for (int i = 0; i < kFrames; ++i) {
    ingest::Frame frame = red_ball(i, 0.05 * i - 0.3);
    disturb(frame);
    frame.clean_depth = ingest::clean_depth(frame.depth, frame.camera.intrinsics);
    if (labels.size() == 1) frame.labels = {};
    store.add(frame, i);
  }
  const auto still = motion::Motion::still();
  std::vector<DrawableField> fields;
  for (const int label : labels) {
    Progress progress;
    fields.emplace_back(
        train_field({store, label, still}, choose_field_config({store, label, still}), short_training(), progress));
  }
  std::vector<PosedField> posed;
  posed.reserve(fields.size());
  for (const DrawableField& field : fields) posed.push_back(pose(field, motion::Warp(SE3::Identity())));
  const ingest::Frame held_out = red_ball(0, 0.125);
  return bleeding(render(posed, held_out.camera), held_out);
}

std::string name_of_case(const ::testing::TestParamInfo<EdgeCase>& edge) { return edge.param.name; }

class EdgeOfALayer : public ::testing::TestWithParam<EdgeCase> {};
class EdgeWithinALayer : public ::testing::TestWithParam<EdgeCase> {};

// The edge is where labels say, to a fifth of a pixel: 0.06 of three.
TEST_P(EdgeOfALayer, LetsNoColourOver) {
  const Bleeding drawn = learn(GetParam().disturb, {0, kBall});
  EXPECT_LT(drawn.into_ball, 0.06);
  EXPECT_LT(drawn.into_wall, 0.06);
  EXPECT_LT(drawn.beyond, 0.003);
}

INSTANTIATE_TEST_SUITE_P(DisturbedTraining, EdgeOfALayer,
                         ::testing::Values(kExact, kDisplaced, kTooFarOut, kTooFarIn, kFlying), name_of_case);

// Nothing but depth and other views say where it is then: a third of a pixel.
TEST_P(EdgeWithinALayer, LetsLittleColourOver) {
  const Bleeding drawn = learn(GetParam().disturb, {0});
  EXPECT_LT(drawn.into_ball, 0.1);
  EXPECT_LT(drawn.into_wall, 0.1);
  EXPECT_LT(drawn.beyond, 0.003);
}

INSTANTIATE_TEST_SUITE_P(DisturbedTraining, EdgeWithinALayer,
                         ::testing::Values(kExact, kDisplaced, kTooFarOut, kFlying), name_of_case);

} // namespace
} // namespace kinora::fields
