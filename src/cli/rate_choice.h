// How finely a clip's fields are stored, as the command line asks for.
#pragma once

#include <nlohmann/json.hpp>

#include "cli/context.h"
#include "clip/clip.h"
#include "encode/rate_control.h"

namespace kinora::cli {

void add_kb_per_frame_option(CLI::App& command, double& kb_per_frame);

/// `kb_per_frame`: the file's, besides a flat preview, above 0. `usual_bytes`: of the file as clip::write_clip stores
/// it unasked. Warns where the file cannot take so many. `report` gets what was chosen. Throws Error(kInterrupted).
encode::RateChoice choose_rate(const clip::Clip& clip, std::size_t usual_bytes, double kb_per_frame, Context& context,
                               nlohmann::json& report);

} // namespace kinora::cli
