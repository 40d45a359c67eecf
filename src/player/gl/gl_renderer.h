// The renderer's own steps (fields/rendering/renderer.h) by OpenGL 3.3 or OpenGL ES 3.0: posed proxy meshes rasterised,
// density bricks marched and surfaces corrected by the motion in their cell in one fragment shader, the nearest surface
// of all layers kept by the depth buffer, its features and colour evaluated in a second one, and so again for the
// surfaces behind (depth peeling: Everitt, "Interactive Order-Independent Transparency", NVIDIA 2001). The shaders are
// the files in shaders/, which WebGL 2 takes as well. The CPU's picture is the reference; a camera
// among a layer's own bricks is drawn, less closely (docs/experiments/player.md).
#pragma once

#include <memory>
#include <span>
#include <string>

#include "core/camera.h"
#include "core/image.h"
#include "fields/rendering/renderer.h"
#include "player/gl/functions.h"

namespace kinora::player::gl {

/// Of one OpenGL context, which must be current whenever anything here is called, destruction included. Not
/// thread-safe. Layers that were drawn stay in the GPU's memory until this is destroyed.
class GlRenderer {
public:
  /// Surfaces along a pixel's ray that are drawn, nearest first.
  static constexpr int kMaxSurfaces = 4;

  /// Throws Error(kFailure): no OpenGL 3.3 or OpenGL ES 3.0 that draws into float textures, or its compiler refuses the
  /// shaders.
  explicit GlRenderer(const GetFunction& get);
  ~GlRenderer();
  GlRenderer(const GlRenderer&) = delete;
  GlRenderer& operator=(const GlRenderer&) = delete;

  /// GL_RENDERER.
  const std::string& name() const;
  /// Whether it is a program that draws (llvmpipe, softpipe, SwiftShader): then the CPU's own renderer is faster.
  bool is_software() const;

  /// Draws what fields::render() does at full quality, one sample to a pixel, into a texture of its own: sRGB times
  /// opacity, opacity. Throws Error(kUsage) for a picture of no pixels or more than 16384 on a side; kFailure when the
  /// GPU has no memory for it or the context is lost: the object is then of no more use.
  void draw(std::span<const fields::PosedField> layers, const Camera& camera);
  /// That texture (RGBA, half floats; its first row is the picture's lowest); 0 before anything was drawn.
  unsigned texture() const;
  /// What was drawn, as Picture::color.
  ColorImage read();

private:
  class State;
  std::unique_ptr<State> state_;
};

} // namespace kinora::player::gl
