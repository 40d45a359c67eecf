// Drawing by WebGL 2: the player's GPU renderer on the context that JavaScript has made current. Numbers as in
// kinora_module.c.
#include <kinora/player.h>

#include <array>
#include <cstring>
#include <exception>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include <GLES3/gl3.h>

#include "player/gl/gl_renderer.h"
#include "player/player_handle.h"

namespace {

using kinora::player::gl::GlRenderer;

std::string said; // NOLINT: what went wrong last; the module has one thread

void* function(const char* name) {
#define KINORA_GL_ADDRESS(type, name)                                                                                  \
  std::pair<std::string_view, void*>("gl" #name, reinterpret_cast<void*>(&gl##name)),
  static const std::array addresses{KINORA_GL_FUNCTIONS(KINORA_GL_ADDRESS)};
#undef KINORA_GL_ADDRESS
  for (const auto& [known, address] : addresses) {
    if (known == name) return address;
  }
  return nullptr;
}

template <typename Body> int guarded(const Body& body) {
  try {
    body();
    return 0;
  } catch (const std::exception& error) {
    said = error.what();
    return 1;
  }
}

} // namespace

extern "C" {

const char* module_gl_error() { return said.c_str(); }

/// null: this context cannot draw clips.
GlRenderer* module_gl_open() {
  GlRenderer* renderer = nullptr;
  guarded([&] { renderer = new GlRenderer(function); }); // NOLINT: owned by JavaScript
  return renderer;
}

/// Also of a context that was lost: what was drawn with is freed.
void module_gl_close(GlRenderer* renderer) { delete renderer; } // NOLINT: it was owned by JavaScript

/// 0, or 1: it is of no more use.
int module_gl_draw(GlRenderer* renderer, KinoraPlayer* player, double seconds, const double* camera,
                   const std::uint8_t* visible, std::uint8_t* color) {
  return guarded([&] {
    const auto now = player->player();
    const kinora::clip::Clip& clip = now->clip();
    kinora::player::LayerChoice layers;
    for (std::size_t i = 0; i < clip.layers.size(); ++i) {
      if (visible[i] != 0) layers.push_back(i);
    }
    kinora::Camera wanted{
        {static_cast<int>(camera[0]), static_cast<int>(camera[1]), camera[2], camera[3], camera[4], camera[5]}};
    wanted.camera_to_world.matrix() = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(camera + 6);
    const auto posed = now->posed_layers(clip.frame_at(seconds), layers);
    renderer->draw(posed, wanted);
    const kinora::ColorImage picture = renderer->read();
    std::memcpy(color, picture.data(), picture.values().size());
  });
}

} // extern "C"
