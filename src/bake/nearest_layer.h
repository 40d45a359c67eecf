// Which layer a point in the world belongs to.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "clip/clip.h"
#include "core/progress.h"

namespace kinora::bake {

/// For each point (world, metres, as the scene is at `frame`) the number of the layer whose surface is nearest then;
/// of equally near ones the first. Nothing if no layer has a surface. Uses all threads; same bits for any number of
/// them. Throws Error(kInterrupted).
std::vector<std::optional<std::size_t>>
nearest_layers(const clip::Clip& clip, int frame, std::span<const Eigen::Vector3d> points, const Progress& progress);

} // namespace kinora::bake
