#include "openni/format.h"

#include "common/captures.h"
#include "common/deferred.h"
#include "openni/description.h"
#include "openni/oni_reader.h"

namespace kinora::formats {
namespace {

constexpr FormatModule kModule = {"openni", "openni", "for cameras of OpenNI"};

void probe_oni(const char* path, KinoraProbe* answer) {
  const RandomAccessFile file(path);
  const std::vector<std::byte> head = file.read(0, std::min<std::uint64_t>(file.size(), 4));
  if (head.size() == 4 && std::memcmp(head.data(), "NI10", 4) == 0)
    return answer_probe(answer, 95, "begins with NI10, as OpenNI's recordings do");
  answer_probe(answer, 0, "does not begin with NI10");
}

std::unique_ptr<OniReader> open_oni(const char* path, const OptionMap& options) {
  return std::make_unique<OniReader>(path, option_number(options, "focal", 0));
}

constexpr KinoraOption kOptions[] = {
    {"focal", "number", "0", "Focal length of the colour camera in pixels; 0: as the file says.", nullptr}};

constexpr KinoraFormat oni_format() {
  auto format = make_struct<KinoraFormat>();
  format.name = "oni";
  format.description = "recording of OpenNI (.oni): Xtion, Astra, Structure and others";
  format.extensions = "";
  format.options = kOptions;
  format.option_count = std::size(kOptions);
  format.probe = safe_probe<probe_oni>;
  set_reader<OniReader, open_oni>(format);
  return format;
}

} // namespace

constinit const KinoraFormat kOniFormat = oni_format();

const KinoraFormat& openni_format() {
  static const KinoraFormat format = deferred_camera<kModule>(openni_description());
  return format;
}

} // namespace kinora::formats
