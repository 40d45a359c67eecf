// Triangles to pictures: a z-buffer with perspective-correct attributes, one lamp with shadows.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "core/camera.h"
#include "core/image.h"

namespace kinora::simulator {

/// A surface at one time.
struct Surface {
  std::vector<Eigen::Vector3d> vertices; ///< world, metres
  std::vector<Eigen::Vector3d> rest;     ///< the same vertices where `colour` knows them
  std::vector<std::array<int, 3>> faces; ///< seen from both sides
  /// Reflectance of red, green and blue at a point of the rest surface, which lies on this face.
  std::function<Eigen::Vector3d(const Eigen::Vector3d&, std::size_t)> colour;
  std::uint8_t label = 0;
  bool smooth = true; ///< shaded by the vertices' normals, else by the faces'
};

struct Light {
  Eigen::Vector3d lamp = {1.5, 3, 2};            ///< world
  Eigen::Vector3d lamp_colour = {0.8, 0.8, 0.8}; ///< on a white surface that faces it
  Eigen::Vector3d ambient = {0.3, 0.3, 0.3};
};

/// What a ray through each pixel's centre meets first.
struct Hits {
  DepthImage depth; ///< metres along the optical axis, 0: nothing
  Image<std::int32_t> surface;
  Image<std::int32_t> face;
  Image<float> weights; ///< barycentric: of corners 1 and 2
};

/// Triangles that reach behind the camera are left out: rooms are made of small ones.
Hits rasterize(const std::vector<Surface>& surfaces, const Camera& camera);

struct View {
  Image<float> light; ///< linear, three channels, the mean of 2×2 samples a pixel
  DepthImage depth;
  LabelImage labels;
};

View render(const std::vector<Surface>& surfaces, const Light& light, const Camera& camera);

} // namespace kinora::simulator
