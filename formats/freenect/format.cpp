#include "freenect/format.h"

#include "common/deferred.h"
#include "freenect/description.h"

namespace kinora::formats {

static constexpr FormatModule kModule = {"freenect", "freenect", "for cameras of the first Kinect"};

const KinoraFormat& freenect_format() {
  static const KinoraFormat format = deferred_camera<kModule>(freenect_description());
  return format;
}

} // namespace kinora::formats
