// Formats that the program knows, by what they can do.
#pragma once

#include <algorithm>
#include <initializer_list>
#include <set>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

#include "cli/run_kinora.h"

namespace kinora::test {

/// The names of those with at least one of the capabilities, as kinora formats --json calls them.
inline std::set<std::string> formats_with_any(const TemporaryFolder& folder,
                                              std::initializer_list<std::string_view> capabilities) {
  std::set<std::string> names;
  const auto told = nlohmann::json::parse(run_kinora(folder, {"formats", "--json"}).out);
  for (const auto& format : told["formats"]) {
    for (const std::string& can : format["capabilities"].get<std::set<std::string>>()) {
      if (std::ranges::find(capabilities, can) != capabilities.end()) names.insert(format["name"].get<std::string>());
    }
  }
  return names;
}

/// Those that something is written in which is made of a clip.
inline std::set<std::string> export_formats(const TemporaryFolder& folder) {
  return formats_with_any(folder, {"write-meshes", "write-volumes", "write-pictures"});
}

} // namespace kinora::test
