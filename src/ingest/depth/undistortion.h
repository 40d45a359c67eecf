// Removes lens distortion from images.
#pragma once

#include "core/camera.h"
#include "core/image.h"

namespace kinora::ingest {

/// A map from the pixels of an ideal pinhole image to those of the distorted one with the same intrinsics
/// (Brown–Conrady; the forward model needs no iteration). Colour is interpolated; depth and labels take the nearest
/// pixel, for a mean of two surfaces is a surface that does not exist. What lies outside is black or 0.
/// Thread-safe to use once it is made. Images must have the size of the intrinsics.
class Undistortion {
public:
  Undistortion(const Intrinsics& intrinsics, const Distortion& distortion);

  ColorImage color(const ColorImage& distorted) const;
  DepthImage depth(const DepthImage& distorted) const;
  LabelImage labels(const LabelImage& distorted) const;

private:
  struct Source {
    float u;
    float v;
  };
  template <class T> Image<T> nearest(const Image<T>& distorted) const;

  int width_;
  int height_;
  std::vector<Source> sources_; ///< one per pixel, row by row
};

} // namespace kinora::ingest
