// A sheet that bends: its live space, and a field trained and drawn through the bending.
#include <gtest/gtest.h>

#include <cmath>

#include "bending_sheet.h"
#include "core/metrics.h"
#include "core/random.h"
#include "fields/renderer.h"
#include "fields/trainer.h"

namespace kinora::fields {
namespace {

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
                                        progress));
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
