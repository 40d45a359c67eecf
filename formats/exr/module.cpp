// The module exr: a plugin of one format.
#include "exr/description.h"
#include "exr/exr_writer.h"

namespace kinora::formats {
namespace {

ExrWriter* self(KinoraWriter* writer) { return reinterpret_cast<ExrWriter*>(writer); }

ExrCompression compression_called(const std::string& name) {
  if (name == "piz") return ExrCompression::kPiz;
  return name == "none" ? ExrCompression::kNone : ExrCompression::kZip;
}

KinoraStatus open_exr(const char* path, const KinoraOptionValue* options, size_t option_count, KinoraWriter** writer,
                      KinoraMessage* message) {
  return guarded(message, [&] {
    const auto given = option_map(options, option_count);
    const auto layout = given.find("layout");
    const auto compression = given.find("compression");
    const auto chosen = PictureFiles::layout_of(layout == given.end() ? "auto" : layout->second, path, ".exr");
    *writer = reinterpret_cast<KinoraWriter*>(new ExrWriter(
        {path, chosen, ".exr"}, compression_called(compression == given.end() ? "" : compression->second)));
    return KINORA_OK;
  });
}

KinoraStatus write_exr(KinoraWriter* writer, const KinoraPicture* picture, KinoraMessage* message) {
  return guarded(message, [&] {
    self(writer)->write(*picture);
    return KINORA_OK;
  });
}

KinoraStatus finish_exr(KinoraWriter* writer, KinoraMessage* message) {
  const std::unique_ptr<ExrWriter> owned(self(writer));
  return guarded(message, [&] {
    owned->finish();
    return KINORA_OK;
  });
}

void abandon_exr(KinoraWriter* writer) { delete self(writer); }

constexpr KinoraFormat module_format() {
  KinoraFormat format = exr_description();
  format.open_writer = open_exr;
  format.writer_write = write_exr;
  format.writer_finish = finish_exr;
  format.writer_abandon = abandon_exr;
  return format;
}

constexpr KinoraFormat kFormat = module_format();

} // namespace
} // namespace kinora::formats

extern "C" const KinoraPlugin* kinora_plugin(std::uint32_t host_abi_version) {
  static const KinoraFormat* const formats[] = {&kinora::formats::kFormat};
  static const KinoraPlugin plugin = {sizeof(KinoraPlugin), KINORA_PLUGIN_ABI, "exr", "", formats, 1};
  return host_abi_version == KINORA_PLUGIN_ABI ? &plugin : nullptr;
}
