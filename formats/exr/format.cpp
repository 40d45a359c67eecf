#include "exr/format.h"

#include "common/captures.h"
#include "common/deferred.h"
#include "exr/description.h"
#include "exr/sequence_probe.h"

namespace kinora::formats {

static constexpr FormatModule kModule = {"exr", "exr", "to write OpenEXR pictures"};
static constexpr FormatModule kSequenceModule = {"exr", "exr-sequence", "for OpenEXR files"};

const KinoraFormat& exr_format() {
  static const KinoraFormat format = deferred_format<kModule>(exr_description());
  return format;
}

const KinoraFormat& exr_sequence_format() {
  static const KinoraFormat format = [] {
    KinoraFormat made = deferred_format<kSequenceModule>(exr_sequence_description());
    made.probe = safe_probe<probe_exr_sequence>;
    return made;
  }();
  return format;
}

} // namespace kinora::formats
