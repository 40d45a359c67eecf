#include "player/gl/gl_renderer.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/error.h"
#include "fields/scenes/drawn_scene.h"
#include "surfaceless_context.h"

namespace kinora::player::gl {
namespace {

using fields::DrawableField;
using fields::PosedField;
using fields::testing::camera_at;
using fields::testing::kBox;
using fields::testing::Paint;
using fields::testing::painted_field;
using fields::testing::PaintedBall;
using testing::SurfacelessContext;

/// Of two pictures on black.
double psnr_of(const ColorImage& a, const ColorImage& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.pixel_count(); ++i) {
    const std::uint8_t* p = a.data() + 4 * i;
    const std::uint8_t* q = b.data() + 4 * i;
    for (int c = 0; c < 3; ++c) {
      const double difference = (p[c] * p[3] - q[c] * q[3]) / 255.0;
      sum += difference * difference;
    }
  }
  return 10 * std::log10(255 * 255 / std::max(sum / (3.0 * static_cast<double>(a.pixel_count())), 1e-9));
}

/// A floor that stays, a ball that is moved and turned, and one that is bent.
struct Scene {
  std::shared_ptr<const motion::DeformationGraph> graph = fields::testing::graph_of_box();
  DrawableField floor{painted_field(kBox, [](const Eigen::Vector3d& at) {
    const double wave = 0.5 + 0.4 * std::sin(20 * at.x()) * std::cos(20 * at.z());
    return Paint{0.35 - at.y(), {wave, 0.3, 1 - wave}};
  })};
  DrawableField moved{painted_field(kBox, PaintedBall{{0.1, 0.1, 0}, 0.15}, 8, true)};
  DrawableField bent{painted_field(kBox, PaintedBall{{-0.15, 0, 0}, 0.22}), graph.get()};
  std::vector<PosedField> layers;

  Scene() {
    SE3 pose(Eigen::Translation3d(0.1, -0.05, -0.15));
    pose.rotate(Eigen::AngleAxisd(0.6, Eigen::Vector3d(1, 2, 0.5).normalized()));
    std::vector<DualQuaternion> nodes;
    for (const Eigen::Vector3d& node : graph->nodes()) {
      SE3 of_node(Eigen::Translation3d(0.08 * node.y(), 0.05 * node.x(), 0.1 * node.x() * node.x()));
      of_node.rotate(Eigen::AngleAxisd(0.5 * node.y(), Eigen::Vector3d::UnitZ()));
      nodes.push_back(DualQuaternion::from(of_node));
    }
    layers = {fields::pose(floor, motion::Warp(SE3::Identity())), fields::pose(moved, motion::Warp(pose)),
              fields::pose(bent, motion::Warp(graph, nodes))};
  }
};

class GlPicture : public ::testing::TestWithParam<SurfacelessContext::Kind> {
protected:
  void SetUp() override {
    if (!context_.is_current()) GTEST_SKIP() << "no OpenGL context without a display can be made here";
  }
  void expect_close(std::span<const PosedField> layers, const Camera& camera, const char* from) {
    GlRenderer renderer(SurfacelessContext::function);
    renderer.draw(layers, camera);
    const ColorImage reference = fields::render(layers, camera).color;
    EXPECT_GE(psnr_of(renderer.read(), reference), 38) << from;
    double drawn = 0;
    for (std::size_t i = 0; i < reference.pixel_count(); ++i) drawn += reference.data()[4 * i + 3] / 255.0;
    EXPECT_GT(drawn, 0.005 * static_cast<double>(reference.pixel_count())) << from;
  }

  SurfacelessContext context_{GetParam()};
  Scene scene_;
};

const Eigen::Vector3d kMiddle(0, 0.05, 0);

TEST_P(GlPicture, IsTheProcessorsOnAllLayersFromNearFarAndAside) {
  expect_close(scene_.layers, camera_at({0, -0.1, -1.4}, kMiddle), "before it");
  expect_close(scene_.layers, camera_at({0.05, -0.1, -0.6}, kMiddle), "near");
  expect_close(scene_.layers, camera_at({0, -0.6, -4}, kMiddle), "far");
  expect_close(scene_.layers, camera_at({1.3, -0.3, -0.2}, kMiddle), "aside");
}

TEST_P(GlPicture, IsTheProcessorsOfEachLayerAlone) {
  for (const PosedField& layer : scene_.layers) {
    expect_close({&layer, 1}, camera_at({0.4, -0.2, -1.1}, kMiddle), "one layer");
  }
}

TEST_P(GlPicture, IsTheProcessorsOfALayerOfWhichHalfIsNotBorn) {
  motion::UnbornNodes unborn;
  for (const Eigen::Vector3d& node : scene_.graph->nodes()) unborn.push_back(node.x() > -0.15);
  scene_.layers[2] = fields::pose(scene_.bent, *scene_.layers[2].warp, unborn);
  expect_close({&scene_.layers[2], 1}, camera_at({0, -0.1, -1.2}, kMiddle), "before it");
  expect_close({&scene_.layers[2], 1}, camera_at({1.0, -0.3, -0.2}, kMiddle), "aside");
  expect_close(scene_.layers, camera_at({0.4, -0.2, -1.1}, kMiddle), "all layers");
}

TEST_P(GlPicture, NoRaySlipsThroughAFloor) {
  const DrawableField floor(fields::testing::sloping_floor());
  const PosedField posed = fields::pose(floor, motion::Warp(SE3::Identity()));
  GlRenderer renderer(SurfacelessContext::function);
  for (int i = 0; i < 24; i += 2) {
    renderer.draw({&posed, 1}, fields::testing::camera_that_grazes(i));
    const ColorImage picture = renderer.read();
    for (std::size_t k = 0; k < picture.pixel_count(); ++k) {
      ASSERT_GT(picture.data()[4 * k + 3], 127) << "camera " << i << ", pixel " << k;
    }
  }
}

TEST_P(GlPicture, OfNoLayersIsEmpty) {
  GlRenderer renderer(SurfacelessContext::function);
  renderer.draw({}, camera_at({0, 0, -1}, kMiddle, 16, 12));
  const ColorImage picture = renderer.read();
  for (std::size_t i = 0; i < picture.pixel_count(); ++i) ASSERT_EQ(picture.data()[4 * i + 3], 0);
}

TEST_P(GlPicture, FollowsTheSizeThatIsAskedFor) {
  GlRenderer renderer(SurfacelessContext::function);
  for (const int width : {96, 31, 1}) {
    const Camera camera = camera_at({0, -0.1, -1.4}, kMiddle, width, 24);
    renderer.draw(scene_.layers, camera);
    EXPECT_EQ(renderer.read().width(), width);
  }
  EXPECT_THROW(renderer.draw(scene_.layers, camera_at({0, 0, -1}, kMiddle, 0, 0)), Error);
}

INSTANTIATE_TEST_SUITE_P(All, GlPicture,
                         ::testing::Values(SurfacelessContext::Kind::kEs3, SurfacelessContext::Kind::kCore33),
                         [](const auto& kind) { return kind.param == SurfacelessContext::Kind::kEs3 ? "Es" : "Core"; });

TEST(GlFunctions, ThatAreNotThereAreNamed) {
  try {
    const GlRenderer renderer([](const char*) -> void* { return nullptr; });
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("glGetString"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("draw by the CPU"), std::string::npos);
  }
}

} // namespace
} // namespace kinora::player::gl
