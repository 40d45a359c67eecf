// The module openni: a plugin of one format.
#include "common/captures.h"
#include "common/module_plugin.h"
#include "openni/description.h"
#include "openni/openni_camera.h"

namespace kinora::formats {
namespace {

std::unique_ptr<OpenNiCamera> open_camera(const char* path, const OptionMap& options) {
  return std::make_unique<OpenNiCamera>(path, option_number(options, "seconds", 60),
                                        option_number(options, "focal", 0));
}

constexpr KinoraFormat kFormat = with_reader<OpenNiCamera, open_camera>(openni_description());

} // namespace
} // namespace kinora::formats

extern "C" const KinoraPlugin* kinora_plugin(std::uint32_t host_abi_version) {
  return kinora::formats::module_plugin<kinora::formats::kFormat>(host_abi_version);
}
