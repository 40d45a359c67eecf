#include "freenect/format.h"

#include "common/deferred.h"
#include "freenect/description.h"

namespace kinora::formats {

static constexpr FormatModule kModule = {"freenect", "freenect", "for cameras of the first Kinect"};

const KinoraFormat& freenect_format() {
  static const KinoraFormat format = [] {
    KinoraFormat made = deferred_format<kModule>(freenect_description());
    made.probe = [](const char* /*path*/, KinoraProbe* answer) {
      answer_probe(answer, 0, "no file, but a camera: name it freenect:0");
    };
    return made;
  }();
  return format;
}

} // namespace kinora::formats
