#include "ingest/depth/depth_unit.h"

#include <algorithm>
#include <vector>

#include <fmt/format.h>

namespace kinora::ingest {

std::string depth_unit_warning(const DepthImage& depth) {
  constexpr float kNearest = 0.25F; // metres
  constexpr float kFarthest = 15;
  std::vector<float> measured;
  for (const float z : depth.values()) {
    if (z > 0) measured.push_back(z);
  }
  if (measured.empty()) return "";
  const auto middle = measured.begin() + static_cast<std::ptrdiff_t>(measured.size() / 2);
  std::nth_element(measured.begin(), middle, measured.end());
  if (*middle >= kNearest && *middle <= kFarthest) return "";
  return fmt::format("half of what is measured lies {} {:.2g} m; if that cannot be, the capture states a wrong unit of "
                     "depth (depth_factor)",
                     *middle < kNearest ? "nearer than" : "beyond", *middle);
}

} // namespace kinora::ingest
