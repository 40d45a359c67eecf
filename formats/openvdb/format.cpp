#include "openvdb/format.h"

#include "common/deferred.h"
#include "openvdb/description.h"

namespace kinora::formats {

static constexpr FormatModule kModule = {"openvdb", "openvdb", "to write OpenVDB volumes"};

const KinoraFormat& openvdb_format() {
  static const KinoraFormat format = deferred_format<kModule>(openvdb_description());
  return format;
}

} // namespace kinora::formats
