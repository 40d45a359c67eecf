// The module mp4: a plugin of one format.
#include "common/module_plugin.h"
#include "common/writers.h"
#include "mp4/description.h"
#include "mp4/mp4_writer.h"

namespace kinora::formats {
namespace {

std::unique_ptr<Mp4Writer> open_mp4(const char* path, const OptionMap& options) {
  Mp4Settings settings;
  settings.frames_per_second = option_number(options, "fps", settings.frames_per_second);
  settings.jump_seconds = option_number(options, "jump", settings.jump_seconds);
  settings.crf = static_cast<int>(option_number(options, "crf", settings.crf));
  return std::make_unique<Mp4Writer>(path, settings);
}

constexpr KinoraFormat module_format() {
  KinoraFormat format = mp4_description();
  set_picture_writer<Mp4Writer, open_mp4>(format);
  return format;
}

constexpr KinoraFormat kFormat = module_format();

} // namespace
} // namespace kinora::formats

extern "C" const KinoraPlugin* kinora_plugin(std::uint32_t host_abi_version) {
  return kinora::formats::module_plugin<kinora::formats::kFormat>(host_abi_version);
}
