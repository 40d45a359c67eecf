// What a frame shows of the background, at the size at which a moving camera is followed.
#pragma once

#include "ingest/frame/frame.h"
#include "tracking/view/layer_view.h"

namespace kinora::tracking {

/// A frame's background, reduced by whole factors: geometry to at most 160 pixels of width, where means of blocks and
/// planes fitted to them are far below the sensor's noise; colour to at most 320, so that texture stays sharp.
struct BackgroundFrame {
  double time = 0;
  Intrinsics intrinsics; ///< of depth and mask
  DepthImage depth;      ///< means of clean depth over what lies on a block's nearest surface, metres; 0: none
  LabelImage mask;       ///< 1 where all of a block is background
  ColorImage color;      ///< one or two pixels to one of depth, each way
};

/// Label 0, or all of a frame without labels. Throws Error(kFailure) if the frame's images differ in size.
BackgroundFrame reduce_background(const ingest::Frame& frame);

/// The view of it; without LayerView::to_silhouette and LayerView::texture, which the camera's tracking does not use.
LayerView view_background(const BackgroundFrame& frame);

} // namespace kinora::tracking
