// Whether a format's descriptor can be used: a plugin is not trusted.
#pragma once

#include <string>
#include <string_view>

#include "kinora/plugin.h"

namespace kinora::host {

/// What is wrong with name, texts, options or capabilities; empty if nothing. Looks at no function.
std::string fault_of_description(const KinoraFormat& format);

/// Why a descriptor cannot be used, its functions included; empty if it can.
std::string fault_of(const KinoraFormat* format);

/// The capability that a word of capability_names stands for; 0 if there is none.
std::uint64_t capability_called(std::string_view name);

} // namespace kinora::host
