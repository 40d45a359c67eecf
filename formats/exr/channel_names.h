// Which channels of an OpenEXR file are colour, and which is depth.
#pragma once

#include <algorithm>
#include <cctype>
#include <string>
#include <vector>

namespace kinora::formats {

struct ExrChannels {
  std::string color; ///< what stands before R, G and B: "" or a layer, "ViewLayer.Combined."
  std::string depth; ///< empty: none
  bool has_color = false;
};

/// Of the names that a file has. R, G, B and Z go before those of layers; a layer's depth says so in its name, as
/// Blender's "ViewLayer.Depth.Z" does.
inline ExrChannels choose_channels(const std::vector<std::string>& names) {
  const auto has = [&](const std::string& name) { return std::ranges::find(names, name) != names.end(); };
  const auto is_color = [&](const std::string& layer) {
    return has(layer + "R") && has(layer + "G") && has(layer + "B");
  };
  ExrChannels channels;
  channels.has_color = is_color("");
  if (has("Z")) channels.depth = std::string("Z");
  for (const std::string& name : names) {
    const std::string layer = name.substr(0, name.rfind('.') + 1);
    if (!channels.has_color && name == layer + "R" && is_color(layer)) {
      channels.color = layer;
      channels.has_color = true;
    }
    std::string lower = name;
    std::ranges::transform(lower, lower.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (channels.depth.empty() && lower.find("depth") != std::string::npos) channels.depth = name;
  }
  return channels;
}

} // namespace kinora::formats
