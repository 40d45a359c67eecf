// The module openvdb: a plugin of one format.
#include "common/module_plugin.h"
#include "common/writers.h"
#include "openvdb/description.h"
#include "openvdb/vdb_writer.h"

namespace kinora::formats {
namespace {

std::unique_ptr<VdbWriter> open_vdb(const char* path, const OptionMap& options) {
  return std::make_unique<VdbWriter>(path, option_text(options, "precision", "half") == "half");
}

constexpr KinoraFormat module_format() {
  KinoraFormat format = openvdb_description();
  set_volume_writer<VdbWriter, open_vdb>(format);
  return format;
}

constexpr KinoraFormat kFormat = module_format();

} // namespace
} // namespace kinora::formats

extern "C" const KinoraPlugin* kinora_plugin(std::uint32_t host_abi_version) {
  return kinora::formats::module_plugin<kinora::formats::kFormat>(host_abi_version);
}
