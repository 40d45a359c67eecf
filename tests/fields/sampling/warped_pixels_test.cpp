// Pixels carried into the canonical space of a sheet that bends: where their rays are there, and what they say is
// empty.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "core/parallel.h"
#include "fields/sampling/ray_sampler.h"
#include "fields/sampling/space_observations.h"
#include "fields/sampling/surface_band.h"
#include "fields/sampling/warped_pixels.h"
#include "fields/scenes/bending_sheet.h"
#include "fields/training/trainer.h"

namespace kinora::fields {
namespace {

Eigen::Vector3d canonical_point(const FieldBox& box, const FieldRay& ray, double depth) {
  const std::array<float, 3> p = point_at(ray, static_cast<float>(depth));
  return box.origin + box.side * Eigen::Vector3f(p.data()).cast<double>();
}

const StoredFrame& frame_of(const PixelStore& store, std::size_t pixel) {
  for (const StoredFrame& frame : store.frames()) {
    if (pixel < frame.end) return frame;
  }
  return store.frames().back();
}

/// Where the camera has the pixel at a depth.
Eigen::Vector3d world_point(const PixelStore& store, std::size_t pixel, double depth) {
  const StoredFrame& frame = frame_of(store, pixel);
  const RowRay ray = frame.ray(store.pixels()[pixel]);
  return frame.camera.camera_to_world * (ray.origin + depth * ray.direction);
}

/// A sheet, its field's box, and the space about its surface.
struct Sheet {
  Performance performance;
  FieldConfig config;
  Occupancy occupancy;

  explicit Sheet(const Twist& readout = Twist::Zero()) {
    performance.store.set_readout(std::vector<Twist>(9, readout));
    config = choose_field_config({performance.store, 1, performance.motion});
    occupancy = RaySampler({performance.store, 1, performance.motion}, config, {}).occupancy();
  }
  SpaceObservations space() const {
    return observe_occupied_space({performance.store, 1, performance.motion}, config, occupancy, 0.05F);
  }
};

/// While a picture is read the camera stands still, or moves by some pixels in all.
class WarpedPixelsOfACamera : public ::testing::TestWithParam<Twist> {};

INSTANTIATE_TEST_SUITE_P(StillAndMoving, WarpedPixelsOfACamera,
                         ::testing::Values(Twist::Zero(),
                                           (Twist() << 0.02, -0.01, 0.01, 0.02, 0.03, -0.02).finished()));

TEST_P(WarpedPixelsOfACamera, StayOnTheirRaysAboutTheMeasuredSurface) {
  const Sheet sheet(GetParam());
  const PixelStore& store = sheet.performance.store;
  const auto warped = warp_measured_pixels({store, 1, sheet.performance.motion}, sheet.config);
  std::size_t measured = 0;
  for (const StoredPixel& pixel : store.pixels()) measured += pixel.label == 1 && pixel.depth.is_known() ? 1 : 0;
  EXPECT_EQ(warped.size(), measured);
  for (std::size_t i = 0; i < warped.size(); i += 37) {
    const StoredPixel& pixel = store.pixels()[warped[i].pixel];
    const motion::Warp warp = sheet.performance.motion.warp(frame_of(store, warped[i].pixel).frame);
    const float depth = pixel.depth.metres();
    const double band = surface_band(sheet.config, depth);
    for (const double behind : {-band, -0.5 * band, 0.0, band}) {
      Eigen::Vector3d position = canonical_point(sheet.config.box, warped[i].ray, depth + behind);
      const auto& curvature = warped[i].curvatures[behind > 0 ? 1 : 0];
      position += behind * behind * sheet.config.box.side * Eigen::Vector3f(curvature.data()).cast<double>();
      const auto world = warp.to_world(position);
      ASSERT_TRUE(world);
      EXPECT_LT((*world - world_point(store, warped[i].pixel, depth + behind)).norm(), 5e-4);
    }
  }
}

TEST_P(WarpedPixelsOfACamera, SayThatSpaceBeforeAMeasuredSurfaceIsEmpty) {
  const Sheet sheet(GetParam());
  const PixelStore& store = sheet.performance.store;
  const SpaceObservations space = sheet.space();
  ASSERT_GT(space.free_space.size(), 1000U); // the wall is seen past the sheet's rim
  for (std::size_t i = 0; i < space.free_space.size(); i += 17) {
    const RaySegment& segment = space.free_space[i];
    const StoredPixel& pixel = store.pixels()[segment.pixel];
    EXPECT_LT(segment.segment.begin, segment.segment.end);
    EXPECT_LE(segment.segment.end, pixel.label == 1 ? pixel.depth.metres() : free_space_until(pixel));
    const double middle = 0.5 * (static_cast<double>(segment.segment.begin) + static_cast<double>(segment.segment.end));
    const auto world = sheet.performance.motion.warp(frame_of(store, segment.pixel).frame)
                           .to_world(canonical_point(sheet.config.box, segment.ray, middle));
    ASSERT_TRUE(world);
    EXPECT_LT((*world - world_point(store, segment.pixel, middle)).norm(), 2e-3);
  }
}

TEST(WarpedPixels, WithoutDepthBeginWhereTheyFirstMeetTheLayer) {
  const Sheet sheet;
  // One of the views, in which the sensor sees nothing of the sheet.
  const ingest::Frame truth = sheet_frame(4, curvature_at(4));
  ingest::Frame blind = truth;
  std::size_t sheet_pixels = 0;
  for (std::size_t i = 0; i < blind.labels.pixel_count(); ++i) {
    if (blind.labels.data()[i] != 1) continue;
    ++sheet_pixels;
    blind.depth.data()[i] = blind.clean_depth.data()[i] = 0;
  }
  PixelStore store(1'000'000, 1);
  store.add(blind, 4);
  const SpaceObservations space =
      observe_occupied_space({store, 1, sheet.performance.motion}, sheet.config, sheet.occupancy, 0.05F);
  EXPECT_GT(space.unmeasured.size(), sheet_pixels * 9 / 10);
  for (const RaySegment& found : space.unmeasured) {
    const StoredPixel& pixel = store.pixels()[found.pixel];
    EXPECT_EQ(pixel.label, 1);
    const float depth = truth.depth.at(pixel.u, pixel.v);
    EXPECT_GT(found.segment.begin, depth - 0.1F);
    EXPECT_LT(found.segment.begin, depth + 0.05F);
    EXPECT_GT(found.segment.end, found.segment.begin);
  }
}

TEST(WarpedPixels, AreTheSameForAnyNumberOfThreads) {
  const Sheet sheet;
  const auto bytes_equal = [](const auto& a, const auto& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(a[0])) == 0;
  };
  set_thread_count(1);
  const auto warped = warp_measured_pixels({sheet.performance.store, 1, sheet.performance.motion}, sheet.config);
  const SpaceObservations space = sheet.space();
  for (const int threads : {2, 7}) {
    set_thread_count(threads);
    EXPECT_TRUE(bytes_equal(
        warped, warp_measured_pixels({sheet.performance.store, 1, sheet.performance.motion}, sheet.config)));
    EXPECT_TRUE(bytes_equal(space.free_space, sheet.space().free_space));
  }
  set_thread_count(0);
}

} // namespace
} // namespace kinora::fields
