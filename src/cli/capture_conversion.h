// A capture turned into another format of captures.
#pragma once

#include <filesystem>
#include <string>

#include "cli/context.h"
#include "core/frame_range.h"
#include "host/options.h"

namespace kinora::cli {

struct CaptureConversion {
  std::filesystem::path input;
  std::filesystem::path output; ///< a folder where the target's format has no extension
  std::string source_format;    ///< empty: whoever recognises the input best
  const KinoraFormat* target = nullptr;
  FrameRange frames;
  host::Options options; ///< of either format
  bool dry_run = false;
  bool strict = false; ///< what the target cannot keep is an error instead of a warning
};

/// Streams frame by frame; nothing is seen under the output's name until it is whole. Prints what was written.
void convert_capture(const CaptureConversion& conversion, Context& context);

} // namespace kinora::cli
