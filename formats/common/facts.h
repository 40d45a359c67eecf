// What a writer is told of how its output was made.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "kinora/plugin.h"

namespace kinora::formats {

/// Names and texts, each on one line.
using Facts = std::vector<std::pair<std::string, std::string>>;

inline Facts facts_of(const KinoraOptionValue* facts, std::size_t count) {
  Facts copied;
  for (std::size_t i = 0; i < count; ++i) {
    copied.emplace_back(facts[i].name, facts[i].value);
    for (char& c : copied.back().second) {
      if (static_cast<unsigned char>(c) < ' ') c = ' ';
    }
  }
  return copied;
}

/// "PREFIX name: value" and the end of a line for each.
inline std::string lines_of(const Facts& facts, const std::string& prefix) {
  std::string text;
  for (const auto& [name, value] : facts) text.append(prefix).append(name).append(": ").append(value).append("\n");
  return text;
}

} // namespace kinora::formats
