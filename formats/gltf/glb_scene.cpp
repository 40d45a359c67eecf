#include "gltf/glb_scene.h"

namespace kinora::formats {

int GlbScene::add_mesh(nlohmann::json mesh) {
  meshes.push_back(std::move(mesh));
  return static_cast<int>(meshes.size()) - 1;
}

int GlbScene::add_node(nlohmann::json node) {
  nodes.push_back(std::move(node));
  return static_cast<int>(nodes.size()) - 1;
}

int GlbScene::add_times(GlbBuffer& buffer, const std::vector<float>& times) {
  const auto [entry, is_new] = times_.try_emplace(times, 0);
  if (is_new) entry->second = buffer.add(std::span<const float>(times), kGlbScalars, GlbTarget::kNone);
  return entry->second;
}

void GlbScene::animate(int node, const char* path, int times, int values, Interpolation interpolation) {
  animation["channels"].push_back(
      {{"sampler", animation["samplers"].size()}, {"target", {{"node", node}, {"path", path}}}});
  animation["samplers"].push_back({{"input", times},
                                   {"output", values},
                                   {"interpolation", interpolation == Interpolation::kStep ? "STEP" : "LINEAR"}});
}

} // namespace kinora::formats
