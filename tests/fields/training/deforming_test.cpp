// A sheet that bends: a field trained and drawn through the bending.
#include <gtest/gtest.h>

#include <cmath>

#include "core/metrics.h"
#include "fields/rendering/renderer.h"
#include "fields/scenes/bending_sheet.h"
#include "fields/training/trainer.h"

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

TEST(Deforming, SheetIsLearntThroughItsBending) {
  const Performance performance;
  TrainerConfig trainer;
  trainer.rays = 600'000;
  trainer.rays_per_step = 1024;
  Progress progress;
  const DrawableField sheet(train_field({performance.store, 1, performance.motion},
                                        choose_field_config({performance.store, 1, performance.motion}), trainer,
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
