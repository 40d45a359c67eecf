// The module exr: a plugin of two formats.
#include "common/captures.h"
#include "common/module_plugin.h"
#include "exr/description.h"
#include "exr/exr_writer.h"
#include "exr/sequence_probe.h"
#include "exr/sequence_reader.h"
#include "exr/sequence_writer.h"

namespace kinora::formats {
namespace {

ExrCompression compression_of(const OptionMap& options, const char* otherwise) {
  return compression_called(option_text(options, "compression", otherwise));
}

std::unique_ptr<ExrWriter> open_exr(const char* path, const OptionMap& options) {
  const auto layout = PictureFiles::layout_of(option_text(options, "layout", "auto"), path, ".exr");
  return std::make_unique<ExrWriter>(PictureFiles(path, layout, ".exr"), compression_of(options, "zip"),
                                     layout == PictureFiles::Layout::kFolder &&
                                         option_text(options, "views") == "parts");
}

std::unique_ptr<ExrSequenceReader> open_sequence(const char* path, const OptionMap& options) {
  return std::make_unique<ExrSequenceReader>(path, option_is_set(options, "masks", true));
}

std::unique_ptr<ExrSequenceWriter> open_sequence_writer(const char* path, const OptionMap& options) {
  return std::make_unique<ExrSequenceWriter>(path, compression_of(options, "piz"));
}

constexpr KinoraFormat picture_format() {
  KinoraFormat format = exr_description();
  set_picture_writer<ExrWriter, open_exr>(format);
  return format;
}

constexpr KinoraFormat sequence_format() {
  KinoraFormat format = exr_sequence_description();
  format.probe = safe_probe<probe_exr_sequence>;
  set_reader<ExrSequenceReader, open_sequence>(format);
  set_writer<ExrSequenceWriter, open_sequence_writer>(format);
  return format;
}

constexpr KinoraFormat kPictures = picture_format();
constexpr KinoraFormat kSequence = sequence_format();

} // namespace
} // namespace kinora::formats

extern "C" const KinoraPlugin* kinora_plugin(std::uint32_t host_abi_version) {
  using namespace kinora::formats;
  return module_plugin<kPictures, kSequence>(host_abi_version);
}
