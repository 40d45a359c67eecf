// The module freenect: a plugin of one format.
#include "common/captures.h"
#include "common/module_plugin.h"
#include "freenect/description.h"
#include "freenect/freenect_reader.h"

namespace kinora::formats {
namespace {

std::unique_ptr<FreenectReader> open_camera(const char* path, const OptionMap& options) {
  return std::make_unique<FreenectReader>(path, option_number(options, "seconds", 60),
                                          option_number(options, "focal", 525));
}

/// The program's own format has the probe.
constexpr KinoraFormat kFormat = with_reader<FreenectReader, open_camera>(freenect_description());

} // namespace
} // namespace kinora::formats

extern "C" const KinoraPlugin* kinora_plugin(std::uint32_t host_abi_version) {
  return kinora::formats::module_plugin<kinora::formats::kFormat>(host_abi_version);
}
