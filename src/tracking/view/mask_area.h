// How a pixel of a view lies to the label that the view is of: the values of a view's mask.
#pragma once

#include <cstdint>

namespace kinora::tracking {

/// Values of LayerView::mask; whatever is not kOutside is the label's.
struct MaskArea {
  static constexpr std::uint8_t kOutside = 0;
  static constexpr std::uint8_t kBorder = 1;   ///< less than two pixels from the label's border
  static constexpr std::uint8_t kInterior = 2; ///< the 5×5 pixels around are the label's, too
};

} // namespace kinora::tracking
