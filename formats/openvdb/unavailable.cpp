// Takes the place of format.cpp and vdb_writer.cpp where the OpenVDB library was not there when Kinora was built.
#include "openvdb/description.h"
#include "openvdb/format.h"

namespace kinora::formats {
namespace {

constexpr const char* kSentence = "OpenVDB files cannot be written: Kinora was built without the OpenVDB library; "
                                  "install libopenvdb-dev and libboost-dev and build "
                                  "again";

KinoraStatus missing(KinoraMessage* message) {
  set_message(message, kSentence);
  return KINORA_MISSING;
}

KinoraStatus open_missing(const char* /*path*/, const KinoraOptionValue* /*options*/, size_t /*option_count*/,
                          KinoraWriter** /*writer*/, KinoraMessage* message) {
  return missing(message);
}
KinoraStatus write_missing(KinoraWriter* /*writer*/, const KinoraVolume* /*volume*/, KinoraMessage* message) {
  return missing(message);
}
KinoraStatus finish_missing(KinoraWriter* /*writer*/, KinoraMessage* message) { return missing(message); }
void abandon_missing(KinoraWriter* /*writer*/) {}

constexpr KinoraFormat openvdb_format() {
  KinoraFormat format = openvdb_description();
  format.description = "OpenVDB fog volumes (not available: built without the OpenVDB library)";
  format.open_writer = open_missing;
  format.writer_volume = write_missing;
  format.writer_finish = finish_missing;
  format.writer_abandon = abandon_missing;
  return format;
}

} // namespace

constinit const KinoraFormat kOpenVdbFormat = openvdb_format();

} // namespace kinora::formats
