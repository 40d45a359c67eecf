#include "gltf/morph_mesh.h"

#include <algorithm>
#include <cmath>

#include "gltf/principal_shapes.h"

namespace kinora::formats {
namespace {

using Json = nlohmann::json;

/// A cube that holds the base, and whose side is no less than the way of any point in any shape.
GlbBox box_of(const PrincipalShapes& shapes) {
  GlbBox box = cube_around(shapes.base);
  for (const std::vector<float>& shape : shapes.shapes) {
    for (const float way : shape) box.scale = std::max(box.scale, std::abs(way));
  }
  return box;
}

int add_shape(GlbBuffer& buffer, const std::vector<float>& shape, bool quantize, const GlbBox& box) {
  if (!quantize) return buffer.add(std::span<const float>(shape), kGlbPositions, GlbTarget::kVertices);
  std::vector<std::int16_t> shares;
  for (std::size_t i = 0; i < shape.size(); ++i) {
    shares.push_back(static_cast<std::int16_t>(std::lround(32767 * shape[i] / box.scale)));
    if (i % 3 == 2) shares.push_back(0);
  }
  return buffer.add(std::span<const std::int16_t>(shares), kGlbBoxWays, GlbTarget::kVertices);
}

} // namespace

int add_morph_mesh(GlbBuffer& buffer, GlbScene& scene, const BlendedMesh& mesh, int material,
                   const MorphSettings& settings) {
  const PrincipalShapes shapes = principal_shapes(mesh, settings.max_shapes);
  const GlbBox box = settings.quantize ? box_of(shapes) : GlbBox{};
  const MeshAttributes attributes(mesh.still(shapes.base.data()),
                                  settings.quantize ? VertexOrder::kDrawing : VertexOrder::kGiven);
  Json primitive = plain_primitive(buffer, attributes, settings.quantize, box);
  primitive["material"] = material;
  Json names = Json::array();
  for (const std::vector<float>& shape : shapes.shapes) {
    primitive["targets"].push_back(
        {{"POSITION", add_shape(buffer, in_order_of(attributes, shape, 3), settings.quantize, box)}});
    names.push_back("shape " + std::to_string(names.size() + 1));
  }
  Json entry = {{"name", mesh.name}, {"primitives", {std::move(primitive)}}};
  const auto count = static_cast<std::ptrdiff_t>(shapes.shapes.size());
  if (count > 0) {
    entry["weights"] = std::vector<float>(shapes.weights.begin(), shapes.weights.begin() + count);
    entry["extras"] = {{"targetNames", std::move(names)}, {"error", shapes.error}};
  }
  Json node = box.node();
  node["name"] = mesh.name;
  node["mesh"] = scene.add_mesh(std::move(entry));
  const int number = scene.add_node(std::move(node));
  if (count > 0 && mesh.times().size() > 1) {
    const std::vector<float> times(mesh.times().begin(), mesh.times().end());
    const int values = buffer.add(std::span<const float>(shapes.weights), kGlbWeights, GlbTarget::kNone);
    scene.animate(number, "weights", scene.add_times(buffer, times), values, settings.interpolation);
  }
  return number;
}

} // namespace kinora::formats
