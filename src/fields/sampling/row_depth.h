// Depth that a sensor reads at once beside colour that it reads row by row.
#pragma once

#include <vector>

#include "fields/sampling/pixel_store.h"

namespace kinora::fields {

/// Depth of one moment becomes what the rows of colour see, which are read while the camera moves so in each frame of
/// the timeline (readout_motion). It stays as it is where what a row sees is hidden, was not stored, or has another
/// label. Same input, same bits, for any number of threads.
void carry_depth_to_rows(PixelStore& store, const std::vector<Twist>& motion);

} // namespace kinora::fields
