// What a picture shows: colours, or what lies behind them, as colours.
#pragma once

#include "fields/rendering/renderer.h"

namespace kinora::player {

enum class PictureView { kColor, kDepth, kNormal, kConfidence };

/// What must be asked of the renderer to show a view.
fields::DrawOptions draw_options_for(PictureView view);

/// Four channels: sRGB and straight alpha, as the picture's own colours.
/// Depth: grey in steps of 1/z, white at the picture's nearest, nearly black at its farthest. Normals: (x right, y up,
/// z back) from −1…1 to 0…255. Confidence: red 0, yellow 128, green 255. The picture must have been drawn with
/// draw_options_for(view).
ColorImage painted(const fields::Picture& picture, PictureView view);

} // namespace kinora::player
