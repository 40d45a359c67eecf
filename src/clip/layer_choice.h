// Some of a clip's layers, chosen by their names.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "clip/clip.h"
#include "core/progress.h"

namespace kinora::clip {

/// Indices into Clip::layers, ascending, each once.
using LayerChoice = std::vector<std::size_t>;

LayerChoice all_layers(const Clip& clip);
/// The layers with these names; names that the clip lacks are warned of and ignored, so the choice may be empty.
LayerChoice choose_layers(const Clip& clip, std::span<const std::string> names, Progress& progress);
/// "background, person"; "none" if the clip has no layer.
std::string layer_names(const Clip& clip);

} // namespace kinora::clip
