// A frame at the size at which a scene is taken apart: at most 320 pixels wide.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/free_space.h"
#include "ingest/frame/frame.h"

namespace kinora::ingest {

constexpr int kReducedWidth = 320;

/// `factor` × `factor` pixels of a frame are one pixel of its view. Depth takes one measurement of the block, never a
/// mean; colour takes the mean.
struct ReducedView {
  Intrinsics intrinsics;
  ColorImage color;
  DepthImage depth; ///< metres; 0: not measured; kUnseen: another camera's view does not tell (`reproject`)
  SE3 camera_to_world = SE3::Identity();
};

constexpr float kUnseen = -1;

/// The least factor that makes an image narrow enough.
constexpr int reduction_factor(int width) { return (width + kReducedWidth - 1) / kReducedWidth; }

ReducedView reduced_view(const Frame& frame, int factor);

/// The pixel whose square holds a point of the image plane. Halves count for the higher one, also after rounding
/// errors.
inline int nearest_pixel(double coordinate) { return static_cast<int>(std::floor(coordinate + 0.5 + 1e-6)); }

/// A point in a camera's space, as that pixel and depth of the camera; nothing outside its image.
struct ProjectedPoint {
  int u, v;
  double z;
};
std::optional<ProjectedPoint> project_point(const Intrinsics& intrinsics, const Eigen::Vector3d& point);

/// Two measurements of one surface, at different times or in neighbouring pixels, differ by less (metres).
constexpr DepthMargin kSameSurface{0.012, 3};
constexpr double same_surface_tolerance(double z) { return kSameSurface.at(z); }

} // namespace kinora::ingest
