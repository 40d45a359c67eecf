// A frame at the size at which a scene is taken apart: at most 320 pixels wide.
#pragma once

#include "ingest/frame.h"
#include "ingest/sensor_noise.h"

namespace kinora::ingest {

constexpr int kSegmentationWidth = 320;

/// `factor` × `factor` pixels of a frame are one pixel of its view. Depth takes one measurement of the block, never a
/// mean; colour takes the mean.
struct SegmentationView {
  Intrinsics intrinsics;
  ColorImage color;
  DepthImage depth;
};

/// The least factor that makes an image narrow enough.
constexpr int segmentation_factor(int width) { return (width + kSegmentationWidth - 1) / kSegmentationWidth; }

SegmentationView segmentation_view(const Frame& frame, int factor);

/// Two measurements of one surface, at different times or in neighbouring pixels, differ by less (metres).
constexpr double same_surface_tolerance(double z) { return std::max(0.012, 3 * depth_sigma(z)); }

} // namespace kinora::ingest
