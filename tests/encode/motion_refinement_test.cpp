// Motion aligned through a field: a bending sheet whose nodes were tracked a little beside their true places.
#include <gtest/gtest.h>

#include "core/parallel.h"
#include "encode/motion_refinement.h"
#include "fields/sampling/contour_pixels.h"
#include "fields/training/trainer.h"
#include "sheet_astray.h"

namespace kinora::encode {
namespace {

using fields::Performance;
using motion::Motion;

using testing::astray;
using testing::edges_of;
using testing::error_of;
using testing::kSpacing;

fields::Field draft_of(const Performance& performance, const Motion& motion) {
  fields::TrainerConfig trainer;
  trainer.rays = 600'000;
  trainer.rays_per_step = 1024;
  Progress progress;
  return fields::train_field({performance.store, 1, motion},
                             fields::choose_field_config({performance.store, 1, motion}), trainer, progress);
}

Motion refine(const Performance& performance, const fields::Field& field, const Motion& motion,
              MotionRefinement* report = nullptr) {
  Progress progress;
  return refine_motion(field, {performance.store, 1, motion}, edges_of(*motion.graph()), kSpacing, progress, report);
}

TEST(MotionRefinement, BringsNodesNearerToTheTruth) {
  const Performance performance;
  const Motion tracked = astray(performance.motion, 0.01); // half a pixel
  MotionRefinement report;
  const Motion refined = refine(performance, draft_of(performance, tracked), tracked, &report);
  EXPECT_EQ(report.frames, performance.store.frames().size());
  EXPECT_LT(report.color_after, 0.9 * report.color_before);
  double before = 0;
  double after = 0;
  for (const fields::StoredFrame& frame : performance.store.frames()) {
    before += error_of(tracked, performance.motion, static_cast<std::size_t>(frame.frame));
    after += error_of(refined, performance.motion, static_cast<std::size_t>(frame.frame));
  }
  EXPECT_LT(after, 0.6 * before) << "mean " << before / 7 << " and " << after / 7 << " m";
}

TEST(MotionRefinement, LeavesARightMotionAlone) {
  const Performance performance;
  const Motion refined = refine(performance, draft_of(performance, performance.motion), performance.motion);
  for (std::size_t f = 0; f < 9; ++f) EXPECT_LT(error_of(refined, performance.motion, f), 0.004) << f;
}

TEST(MotionRefinement, FramesThatAreNotStoredMoveAsTheirNeighbours) {
  const Performance performance;
  const Motion tracked = astray(performance.motion, 0.01);
  const Motion refined = refine(performance, draft_of(performance, tracked), tracked);
  for (const std::size_t f : {3U, 7U}) {
    const auto moved = [&](std::size_t frame, std::size_t n) -> Eigen::Vector3d {
      const Eigen::Vector3d& node = tracked.graph()->nodes()[n];
      const SE3 before = tracked.deformations()[frame].node_to_world[n].to_se3();
      return before.linear().transpose() *
             (refined.deformations()[frame].node_to_world[n].to_se3() * node - before * node);
    };
    for (std::size_t n = 0; n < tracked.graph()->nodes().size(); n += 7) {
      const Eigen::Vector3d mean = 0.5 * (moved(f - 1, n) + moved(f + 1, n));
      EXPECT_LT((moved(f, n) - mean).norm(), 1e-3) << "frame " << f << " node " << n;
    }
  }
}

TEST(MotionRefinement, LostFramesAndUnseenLayersKeepTheirNodes) {
  const Performance performance;
  std::vector<Motion::Deformation> deformations = astray(performance.motion, 0.01).deformations();
  for (Motion::Deformation& deformation : deformations) deformation.health = motion::Health::kLost;
  const Motion lost = Motion::deforming(performance.motion.graph(), std::move(deformations));
  MotionRefinement report;
  const fields::Field field = draft_of(performance, performance.motion);
  const Motion refined = refine(performance, field, lost, &report);
  EXPECT_EQ(report.frames, 0U);
  for (std::size_t f = 0; f < 9; ++f) EXPECT_EQ(error_of(refined, lost, f), 0.0);
  Progress progress;
  const Motion nobody = refine_motion(field, {performance.store, 5, performance.motion},
                                      edges_of(*performance.motion.graph()), kSpacing, progress);
  for (std::size_t f = 0; f < 9; ++f) EXPECT_EQ(error_of(nobody, performance.motion, f), 0.0);
}

TEST(MotionRefinement, SameBitsForAnyNumberOfThreads) {
  const Performance performance;
  const Motion tracked = astray(performance.motion, 0.01);
  const fields::Field field = draft_of(performance, tracked);
  set_thread_count(1);
  const Motion one = refine(performance, field, tracked);
  for (const int threads : {2, 7}) {
    set_thread_count(threads);
    const Motion several = refine(performance, field, tracked);
    for (std::size_t f = 0; f < 9; ++f) {
      for (std::size_t n = 0; n < one.graph()->nodes().size(); ++n) {
        const DualQuaternion& a = one.deformations()[f].node_to_world[n];
        const DualQuaternion& b = several.deformations()[f].node_to_world[n];
        EXPECT_EQ(a.real.coeffs(), b.real.coeffs());
        EXPECT_EQ(a.dual.coeffs(), b.dual.coeffs());
      }
    }
  }
  set_thread_count(0);
}

TEST(ContourPixels, LieOnBothSidesOfTheRimAndNowhereElse) {
  const Performance performance;
  const fields::PixelStore& store = performance.store;
  const fields::FieldConfig config = fields::choose_field_config({store, 1, performance.motion});
  const fields::StoredFrame& frame = store.frames().front();
  const ingest::Frame truth = fields::sheet_frame(0, 0);
  const auto nearest_of = [&](const fields::StoredPixel& pixel, int label) { // pixels along a row or column
    int nearest = 100;
    for (int k = -4; k <= 4; ++k) {
      for (const auto& [u, v] : {std::pair(pixel.u + k, +pixel.v), std::pair(+pixel.u, pixel.v + k)}) {
        if (truth.labels.contains(u, v) && truth.labels.at(u, v) == label) nearest = std::min(nearest, std::abs(k));
      }
    }
    return nearest;
  };
  const fields::ContourPixels contour = fields::contour_pixels({store, 1, performance.motion}, frame, config);
  ASSERT_GT(contour.inside.size(), 100U);
  ASSERT_GT(contour.outside.size(), 100U);
  for (const fields::ContourPixel& pixel : contour.inside) {
    EXPECT_EQ(store.pixels()[pixel.pixel].label, 1);
    EXPECT_LE(nearest_of(store.pixels()[pixel.pixel], 0), 2);
  }
  for (const fields::ContourPixel& pixel : contour.outside) {
    EXPECT_EQ(store.pixels()[pixel.pixel].label, 0);
    EXPECT_LE(nearest_of(store.pixels()[pixel.pixel], 1), 2);
    EXPECT_NEAR(pixel.depth, fields::kDistance, 1e-3);
  }
}

} // namespace
} // namespace kinora::encode
