#include "data_set/format.h"

#include "common/writers.h"
#include "data_set/data_set_writer.h"

namespace kinora::formats {
namespace {

std::unique_ptr<DataSetWriter> open_set(const char* path, const OptionMap& /*options*/) {
  return std::make_unique<DataSetWriter>(path);
}

constexpr KinoraFormat data_set_format() {
  auto format = make_struct<KinoraFormat>();
  format.name = "data-set";
  format.description =
      "Data set of nerfstudio and instant-ngp: images, depth, labels, and transforms.json with cameras";
  format.extensions = "";
  format.capabilities =
      KINORA_WRITES_PICTURES | KINORA_WRITES_METRIC_DEPTH | KINORA_WRITES_LABELS | KINORA_WRITES_CAMERAS;
  set_picture_writer<DataSetWriter, open_set>(format);
  return format;
}

} // namespace

constinit const KinoraFormat kDataSetFormat = data_set_format();

} // namespace kinora::formats
