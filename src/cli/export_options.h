// Options of exports that are the same for all formats of a kind: what is baked, and where it lies.
#pragma once

#include <vector>

#include "cli/conversion.h"

namespace kinora::cli {

/// Those that hold for a format of meshes or volumes; one that the format declares itself is left out.
std::vector<KinoraOption> export_options(const KinoraFormat& format);

/// Takes export_options() out of what the user gave and fills in what they say: layers, surface, volume, origin, frames
/// (of those that are there, as `fps` asks), and the rest as options of the format. The clip, the format and the frames
/// are set already. Throws Error(kUsage), also for options that nobody has.
void apply_options(host::Options given, Conversion& conversion, Context& context);

} // namespace kinora::cli
