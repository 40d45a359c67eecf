// Triangles to a picture with exact depth, one sample for each pixel.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "core/camera.h"
#include "core/image.h"
#include "gltf_scene/scene.h"

namespace kinora::formats {

/// What a virtual camera sees. Depth at a pixel's centre is that of the triangle there, to rounding; both sides of
/// triangles are drawn. Source: Pineda, "A Parallel Algorithm for Polygon Rasterization", SIGGRAPH 1988; perspective-
/// correct interpolation: Heckbert and Moreton, 1991.
class Rasterizer {
public:
  explicit Rasterizer(const Camera& camera);

  /// `vertices`: of the primitive, in the world. `images`: of the scene.
  void draw(const ScenePrimitive& primitive, const std::vector<Eigen::Vector3f>& vertices,
            const std::vector<ColorImage>& images, std::uint8_t label);

  const ColorImage& color() const { return color_; }   ///< sRGB, black where nothing is
  const Image<float>& depth() const { return depth_; } ///< metres along the axis, 0 where nothing is
  const LabelImage& labels() const { return labels_; } ///< 0 where nothing is

private:
  struct Corner {
    Eigen::Vector3d position; ///< of the camera
    Eigen::Vector2d texture;
    Eigen::Vector3d color; ///< linear
  };
  struct Surface;

  void draw_clipped(const Corner& a, const Corner& b, const Corner& c, const Surface& surface);
  void fill(const Corner& a, const Corner& b, const Corner& c, const Surface& surface);

  Camera camera_;
  ColorImage color_;
  Image<float> depth_;
  LabelImage labels_;
};

} // namespace kinora::formats
