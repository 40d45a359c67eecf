// What a clip is about: the point that a camera turns around.
#pragma once

#include <optional>

#include "player/player.h"

namespace kinora::player {

/// The first layer that is not still and has a centre at any frame.
std::optional<std::size_t> first_moving_layer(const Player& player);

/// Centre of a layer at that of the frames at which it is there that is nearest to `frame` (of two the earlier one).
std::optional<Eigen::Vector3d> nearest_centre(const Player& player, std::size_t layer, int frame);

/// Of a clip in which nothing moves, in world coordinates: what is near the middle of the capture's pictures and near
/// the camera, taken over the whole clip. Per axis the weighted median of what small pictures along the capture's path
/// show; a pixel weighs exp(−r²/2σ²)/z³, r its distance from the picture's middle, σ a fifth of the picture's height,
/// z its depth in metres, so that a desk counts before the wall behind it. Two metres ahead of the middle frame's
/// camera if nothing is seen.
Eigen::Vector3d still_subject(const Player& player);

/// What the scene is about at a frame, in world coordinates: the first moving layer's nearest centre, else
/// still_subject.
Eigen::Vector3d subject_of(const Player& player, int frame);

} // namespace kinora::player
