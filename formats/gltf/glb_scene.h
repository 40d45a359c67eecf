// What a glTF file lists by number besides its accessors: meshes, nodes and one animation.
#pragma once

#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "gltf/glb_buffer.h"

namespace kinora::formats {

enum class Interpolation { kLinear, kStep };

struct GlbScene {
  nlohmann::json meshes = nlohmann::json::array();
  nlohmann::json nodes = nlohmann::json::array();
  nlohmann::json animation = {
      {"name", "clip"}, {"channels", nlohmann::json::array()}, {"samplers", nlohmann::json::array()}};

  /// Both return the number of what was added.
  int add_mesh(nlohmann::json mesh);
  int add_node(nlohmann::json node);
  /// Seconds; equal times share an accessor, whose number it returns.
  int add_times(GlbBuffer& buffer, const std::vector<float>& times);
  /// `path`: what of the node moves: "translation", "rotation", "scale", "weights". `times`, `values`: accessors.
  void animate(int node, const char* path, int times, int values, Interpolation interpolation);

private:
  std::map<std::vector<float>, int> times_;
};

} // namespace kinora::formats
