#include "data_set/format.h"

#include <memory>

#include "common/boundary.h"
#include "data_set/data_set_writer.h"

namespace kinora::formats {
namespace {

DataSetWriter* self(KinoraWriter* writer) { return reinterpret_cast<DataSetWriter*>(writer); }

KinoraStatus open_set(const char* path, const KinoraOptionValue* /*options*/, size_t /*option_count*/,
                      KinoraWriter** writer, KinoraMessage* message) {
  return guarded(message, [&] {
    *writer = reinterpret_cast<KinoraWriter*>(new DataSetWriter(path));
    return KINORA_OK;
  });
}

KinoraStatus write_set(KinoraWriter* writer, const KinoraPicture* picture, KinoraMessage* message) {
  return guarded(message, [&] {
    self(writer)->write(*picture);
    return KINORA_OK;
  });
}

KinoraStatus finish_set(KinoraWriter* writer, KinoraMessage* message) {
  const std::unique_ptr<DataSetWriter> owned(self(writer));
  return guarded(message, [&] {
    owned->finish();
    return KINORA_OK;
  });
}

void abandon_set(KinoraWriter* writer) { delete self(writer); }

constexpr KinoraFormat data_set_format() {
  auto format = make_struct<KinoraFormat>();
  format.name = "data-set";
  format.description =
      "Data set of nerfstudio and instant-ngp: images, depth, labels, and transforms.json with cameras";
  format.extensions = "";
  format.capabilities =
      KINORA_WRITES_PICTURES | KINORA_WRITES_METRIC_DEPTH | KINORA_WRITES_LABELS | KINORA_WRITES_CAMERAS;
  format.open_writer = open_set;
  format.writer_write = write_set;
  format.writer_finish = finish_set;
  format.writer_abandon = abandon_set;
  return format;
}

} // namespace

constinit const KinoraFormat kDataSetFormat = data_set_format();

} // namespace kinora::formats
