// What a picture shows: colours, or what lies behind them, as colours.
#pragma once

#include <vector>

#include "fields/rendering/renderer.h"
#include "motion/motion.h"

namespace kinora::player {

enum class PictureView { kColor, kDepth, kNormal, kConfidence, kHealth };

/// What must be asked of the renderer to show a view.
fields::DrawOptions draw_options_for(PictureView view);

/// Four channels: sRGB and straight alpha, as the picture's own colours.
/// Depth: grey in steps of 1/z, white at the picture's nearest, nearly black at its farthest. Normals: (x right, y up,
/// z back) from −1…1 to 0…255. Confidence: red 0, yellow 128, green 255. Health: green where a layer
/// was tracked, yellow where it was held, red where it was lost, in the picture's light and shade. The picture must
/// have been drawn with draw_options_for(view). `health`: of each layer that was drawn, in their order
/// (Player::drawn_health).
ColorImage painted(const fields::Picture& picture, PictureView view, const std::vector<motion::Health>& health = {});

} // namespace kinora::player
