// Options in the form that the plugin interface takes.
#pragma once

#include <vector>

#include "host/options.h"

namespace kinora::host {

/// Pointers into `options`, which must outlive them.
inline std::vector<KinoraOptionValue> option_values(const Options& options) {
  std::vector<KinoraOptionValue> values;
  values.reserve(options.size());
  for (const auto& [name, value] : options) values.push_back({name.c_str(), value.c_str()});
  return values;
}

} // namespace kinora::host
