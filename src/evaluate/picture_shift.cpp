#include "evaluate/picture_shift.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "core/error.h"
#include "ingest/images/optical_flow.h"

namespace kinora::evaluate {
namespace {

/// Nothing where OpenCV is not installed.
std::optional<Image<float>> flow_between(const ColorImage& to, const ColorImage& from) {
  try {
    return ingest::optical_flow(to, from);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kMissingComponent) throw;
    return std::nullopt;
  }
}

} // namespace

void PictureShift::add(const ColorImage& drawn, const ColorImage& truth) {
  if (std::min(drawn.width(), drawn.height()) < kSmallest) return;
  ColorImage shown(drawn.width(), drawn.height(), 3);
  for (std::size_t i = 0; i < shown.pixel_count(); ++i) std::copy_n(drawn.data() + 4 * i, 3, shown.data() + 3 * i);
  const auto flow = flow_between(shown, truth);
  for (std::size_t i = 0; flow && i < flow->pixel_count(); ++i) {
    if (drawn.data()[4 * i + 3] < 128) continue;
    const float length = std::hypot(flow->data()[2 * i], flow->data()[2 * i + 1]);
    const auto bin = static_cast<std::size_t>(std::lround(kBinsPerPixel * std::min<float>(kLongest, length)));
    ++counts_[bin];
  }
}

nlohmann::json PictureShift::json() const {
  const std::size_t all = std::accumulate(counts_.begin(), counts_.end(), std::size_t{0});
  const auto not_exceeded_by = [&](double share) -> nlohmann::json {
    if (all == 0) return nullptr;
    std::size_t so_far = 0;
    std::size_t bin = 0;
    while (bin + 1 < counts_.size() && static_cast<double>(so_far += counts_[bin]) < share * static_cast<double>(all))
      ++bin;
    return static_cast<double>(bin) / kBinsPerPixel;
  };
  return {{"shift_median", not_exceeded_by(0.5)}, {"shift_95", not_exceeded_by(0.95)}};
}

} // namespace kinora::evaluate
