#include "core/camera.h"

#include <cmath>

#include <fmt/format.h>

#include "core/error.h"

namespace kinora {

Intrinsics Intrinsics::resized(int new_width, int new_height) const {
  const double sx = static_cast<double>(new_width) / width;
  const double sy = static_cast<double>(new_height) / height;
  // The image's corner, not the first pixel's centre, stays in place.
  return {new_width, new_height, fx * sx, fy * sy, (cx + 0.5) * sx - 0.5, (cy + 0.5) * sy - 0.5};
}

void Intrinsics::validate(const std::string& source) const {
  const auto reject = [&source](const std::string& why) {
    throw Error(ErrorCode::kCorruptInput,
                fmt::format("{}: {}; give fx, fy, cx and cy in pixels of the images beside it", source, why));
  };
  constexpr int kMaxSide = 16384;
  if (width < 1 || height < 1 || width > kMaxSide || height > kMaxSide) {
    reject(fmt::format("an image of {}x{} pixels is out of range", width, height));
  }
  for (const double value : {fx, fy, cx, cy}) {
    if (!std::isfinite(value)) reject("the intrinsics hold values that are not finite");
  }
  const double longest = std::max(width, height);
  if (fx < 0.05 * longest || fy < 0.05 * longest || fx > 100 * longest || fy > 100 * longest) {
    reject(fmt::format("focal lengths fx={} fy={} are absurd for {}x{} pixels", fx, fy, width, height));
  }
  if (cx < -width || cx > 2.0 * width || cy < -height || cy > 2.0 * height) {
    reject(fmt::format("the principal point cx={} cy={} lies far outside {}x{} pixels", cx, cy, width, height));
  }
}

} // namespace kinora
