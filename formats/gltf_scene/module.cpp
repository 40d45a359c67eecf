// The module gltf_scene: a plugin of one format.
#include "common/captures.h"
#include "common/module_plugin.h"
#include "gltf_scene/description.h"
#include "gltf_scene/scene_reader.h"

namespace kinora::formats {
namespace {

std::unique_ptr<SceneReader> open_scene(const char* path, const OptionMap& options) {
  VirtualCamera camera;
  camera.width = static_cast<int>(option_number(options, "width", camera.width));
  camera.height = static_cast<int>(option_number(options, "height", camera.height));
  camera.frames_per_second = option_number(options, "fps", camera.frames_per_second);
  camera.field_of_view = option_number(options, "fov", camera.field_of_view);
  camera.name = option_text(options, "camera");
  return std::make_unique<SceneReader>(path, camera, option_text(options, "animation"),
                                       option_is_set(options, "masks", true));
}

/// The program's own format has the probe.
constexpr KinoraFormat kFormat = with_reader<SceneReader, open_scene>(gltf_scene_description());

} // namespace
} // namespace kinora::formats

extern "C" const KinoraPlugin* kinora_plugin(std::uint32_t host_abi_version) {
  return kinora::formats::module_plugin<kinora::formats::kFormat>(host_abi_version);
}
