// The quality part of a report, as a person reads it.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

namespace kinora::cli {

/// A table of an evaluation (schema "kinora.evaluation/1"): a line per layer and group of frames.
std::string quality_table(const nlohmann::json& evaluation);

} // namespace kinora::cli
