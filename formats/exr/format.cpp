#include "exr/format.h"

#include "common/deferred.h"
#include "exr/description.h"

namespace kinora::formats {

static constexpr FormatModule kModule = {"exr", "to write OpenEXR pictures"};

const KinoraFormat& exr_format() {
  static const KinoraFormat format = deferred_format<kModule>(exr_description());
  return format;
}

} // namespace kinora::formats
