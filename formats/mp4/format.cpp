#include "mp4/format.h"

#include "common/deferred.h"
#include "mp4/description.h"

namespace kinora::formats {

static constexpr FormatModule kModule = {"mp4", "mp4", "to write MP4 films"};

const KinoraFormat& mp4_format() {
  static const KinoraFormat format = deferred_format<kModule>(mp4_description());
  return format;
}

} // namespace kinora::formats
