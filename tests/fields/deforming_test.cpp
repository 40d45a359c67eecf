// A sheet that bends: its live space, and a field trained and drawn through the bending.
#include <gtest/gtest.h>

#include <cmath>

#include "core/metrics.h"
#include "core/random.h"
#include "fields/live_space.h"
#include "fields/renderer.h"
#include "fields/trainer.h"

namespace kinora::fields {
namespace {

constexpr int kWidth = 96;
constexpr int kHeight = 72;
constexpr double kDistance = 2.0;
constexpr double kHalfWidth = 0.4;
constexpr double kHalfHeight = 0.3;
constexpr double kWall = 3.0;

/// Where the sheet's point (s, y) is when it is bent about the vertical with a curvature in 1/m: edges come nearer.
SE3 sheet_pose(double s, double curvature) {
  const double angle = curvature * s;
  const double x = curvature == 0 ? s : std::sin(angle) / curvature;
  const double z = curvature == 0 ? kDistance : kDistance - (1 - std::cos(angle)) / curvature;
  SE3 pose = SE3::Identity();
  pose.linear() = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY()).toRotationMatrix();
  pose.translation() = Eigen::Vector3d(x, 0, z) - pose.linear() * Eigen::Vector3d(s, 0, kDistance);
  return pose;
}

std::shared_ptr<const tracking::DeformationGraph> sheet_graph() {
  std::vector<Eigen::Vector3d> nodes;
  for (int i = -7; i <= 7; ++i) {
    for (int j = -5; j <= 5; ++j) nodes.emplace_back(0.06 * i, 0.06 * j, kDistance);
  }
  return std::make_shared<const tracking::DeformationGraph>(nodes, 0.075, 0.15);
}

std::vector<DualQuaternion> sheet_nodes(const tracking::DeformationGraph& graph, double curvature) {
  std::vector<DualQuaternion> nodes;
  for (const auto& node : graph.nodes()) nodes.push_back(DualQuaternion::from(sheet_pose(node.x(), curvature)));
  return nodes;
}

/// What a camera at the origin sees of the sheet (label 1) before a wall (label 0).
ingest::Frame sheet_frame(int index, double curvature) {
  ingest::Frame f;
  f.index = index;
  f.camera.intrinsics = {kWidth, kHeight, 100, 100, (kWidth - 1) / 2.0, (kHeight - 1) / 2.0};
  f.color = ColorImage(kWidth, kHeight, 3);
  f.depth = DepthImage(kWidth, kHeight);
  f.labels = LabelImage(kWidth, kHeight);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const Eigen::Vector3d d = f.camera.intrinsics.unproject(u, v, 1);
      double depth = kDistance;
      double s = depth * d.x();
      if (curvature > 0) { // the far side of a cylinder around the camera's axis
        const double radius = 1 / curvature;
        const double centre = kDistance - radius;
        const double a = d.x() * d.x() + 1;
        depth = (centre + std::sqrt(centre * centre - a * (centre * centre - radius * radius))) / a;
        s = radius * std::atan2(depth * d.x(), depth - centre);
      }
      const double y = depth * d.y();
      const bool sheet = std::abs(s) < kHalfWidth && std::abs(y) < kHalfHeight;
      const double wave = 0.5 + 0.4 * std::sin(18 * s) * std::cos(18 * y);
      const Eigen::Vector3d rgb = sheet ? Eigen::Vector3d(wave, 0.3, 1 - wave) : Eigen::Vector3d(0.2, 0.5, 0.4);
      for (int c = 0; c < 3; ++c) f.color.at(u, v, c) = static_cast<std::uint8_t>(std::lround(255 * rgb[c]));
      f.depth.at(u, v) = static_cast<float>(sheet ? depth : kWall);
      f.labels.at(u, v) = sheet ? 1 : 0;
    }
  }
  f.clean_depth = f.depth;
  return f;
}

double curvature_at(int frame) { return 0.15 * frame; }

/// Nine frames of bending; every fourth is not trained on.
struct Performance {
  PixelStore store{1'000'000, 9};
  tracking::Motion motion = tracking::Motion::still();

  Performance() {
    const auto graph = sheet_graph();
    std::vector<tracking::Motion::Deformation> deformations;
    for (int i = 0; i < 9; ++i) {
      if (i % 4 != 3) store.add(sheet_frame(i, curvature_at(i)), i);
      deformations.push_back({sheet_nodes(*graph, curvature_at(i)), tracking::Health::kTracked});
    }
    motion = tracking::Motion::deforming(graph, std::move(deformations));
  }
};

// Over the pixels of the sheet.
float median_depth_error(const Picture& picture, const ingest::Frame& truth) {
  std::vector<float> errors;
  for (std::size_t i = 0; i < truth.depth.pixel_count(); ++i) {
    if (truth.labels.data()[i] == 1) errors.push_back(std::abs(picture.depth.data()[i] - truth.depth.data()[i]));
  }
  const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
  std::nth_element(errors.begin(), middle, errors.end());
  return *middle;
}

TEST(LiveSpace, LeadsBackToTheCanonicalPointOfEverySample) {
  const auto graph = sheet_graph();
  FieldConfig config;
  config.box = {Eigen::Vector3d(-0.45, -0.45, kDistance - 0.45), 0.9};
  config.occupancy_resolution = 64;
  Occupancy occupancy(64);
  for (int y = 8; y < 56; ++y) {
    for (int x = 4; x < 60; ++x) {
      for (int z = 29; z < 35; ++z) occupancy.set(x, y, z);
    }
  }
  for (const double curvature : {0.0, 1.0, 2.5}) {
    const tracking::Warp warp(graph, sheet_nodes(*graph, curvature));
    const LiveSpace live(config, occupancy, warp);
    Random random(1);
    for (int k = 0; k < 2000; ++k) {
      const Eigen::Vector3d canonical(0.78 * (random.uniform_double() - 0.5), 0.6 * (random.uniform_double() - 0.5),
                                      kDistance + 0.06 * (random.uniform_double() - 0.5));
      const Eigen::Vector3d world = *warp.to_world(canonical);
      std::array<float, 3> at{};
      Eigen::Map<Eigen::Vector3f>(at.data()) = ((world - live.box().origin) / live.box().side).cast<float>();
      const LiveSpace::Map* map = live.map_at(at);
      ASSERT_NE(map, nullptr);
      const std::array<float, 3> back = map->apply(at);
      const Eigen::Vector3d found =
          config.box.origin + config.box.side * Eigen::Map<const Eigen::Vector3f>(back.data()).cast<double>();
      EXPECT_LT((found - canonical).norm(), 1e-3) << "curvature " << curvature;
    }
  }
}

TEST(Deforming, SheetIsLearntThroughItsBending) {
  const Performance performance;
  TrainerConfig trainer;
  trainer.rays = 600'000;
  trainer.rays_per_step = 1024;
  Progress progress;
  const DrawableField sheet(train_field(performance.store, 1, performance.motion,
                                        choose_field_config(performance.store, 1, performance.motion), trainer,
                                        progress),
                            performance.motion.graph().get());
  for (const int frame : {3, 7}) {
    const ingest::Frame truth = sheet_frame(frame, curvature_at(frame));
    const PosedField posed = pose(sheet, performance.motion.warp(frame));
    const Picture picture = render({&posed, 1}, truth.camera);
    const ImageMetrics metrics = compare_images(picture.color, truth.color, truth.labels);
    EXPECT_GT(metrics.psnr_inside, 25) << "frame " << frame;
    EXPECT_GT(metrics.iou, 0.93) << "frame " << frame;
    EXPECT_LT(median_depth_error(picture, truth), 0.006F) << "frame " << frame;
  }
  // A motion that is wrong must show.
  const PosedField flat = pose(sheet, performance.motion.warp(0));
  const ingest::Frame bent = sheet_frame(7, curvature_at(7));
  EXPECT_GT(median_depth_error(render({&flat, 1}, bent.camera), bent), 0.012F);
}

} // namespace
} // namespace kinora::fields
