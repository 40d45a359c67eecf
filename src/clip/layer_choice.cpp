#include "clip/layer_choice.h"

#include <algorithm>
#include <numeric>

#include <fmt/format.h>

namespace kinora::clip {

LayerChoice all_layers(const Clip& clip) {
  LayerChoice choice(clip.layers.size());
  std::iota(choice.begin(), choice.end(), std::size_t{0});
  return choice;
}

LayerChoice choose_layers(const Clip& clip, std::span<const std::string> names, Progress& progress) {
  LayerChoice choice;
  for (const std::string& name : names) {
    const auto found = std::find_if(clip.layers.begin(), clip.layers.end(),
                                    [&name](const Layer& layer) { return layer.name == name; });
    if (found == clip.layers.end()) {
      progress.warn(fmt::format("the clip has no layer \"{}\", which is ignored; it has: {}", name, layer_names(clip)));
    } else {
      choice.push_back(static_cast<std::size_t>(found - clip.layers.begin()));
    }
  }
  std::sort(choice.begin(), choice.end());
  choice.erase(std::unique(choice.begin(), choice.end()), choice.end());
  return choice;
}

std::string layer_names(const Clip& clip) {
  std::string names;
  for (const Layer& layer : clip.layers) names += (names.empty() ? "" : ", ") + layer.name;
  return names.empty() ? "none" : names;
}

} // namespace kinora::clip
