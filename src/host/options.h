// Options of formats, as -O key=value gives them.
#pragma once

#include <map>
#include <span>
#include <string>

#include "kinora/plugin.h"

namespace kinora::host {

using Options = std::map<std::string, std::string>;

/// "key=value" words to options; the last of a key counts. Throws Error(kUsage) on a word without a key or '='.
Options parse_options(std::span<const std::string> words);

/// Throws Error(kUsage) if the format does not declare an option or a value is not of its type; the sentence names the
/// nearest option and lists what there is: the format's, and `others`, which the caller has taken out already.
void check_options(const KinoraFormat& format, const Options& options, std::span<const std::string> others = {});

} // namespace kinora::host
