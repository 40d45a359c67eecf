#include "gltf/mesh_sequence.h"

#include "gltf/draco_primitive.h"

namespace kinora::formats {
namespace {

using Json = nlohmann::json;

const float* numbers_of(const std::vector<Eigen::Vector3f>& points) { return points.front().data(); }

/// A cube that holds the mesh in all poses.
GlbBox cube_of_all(const BlendedMesh& mesh) {
  std::vector<float> corners;
  for (std::size_t i = 0; i < mesh.times().size(); ++i) {
    const std::vector<Eigen::Vector3f> points = mesh.points(i);
    Eigen::Vector3f low = points.front();
    Eigen::Vector3f high = points.front();
    for (const Eigen::Vector3f& p : points) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    corners.insert(corners.end(), low.begin(), low.end());
    corners.insert(corners.end(), high.begin(), high.end());
  }
  return cube_around(corners);
}

/// Gives the node its size from the time of its pose to that of the next.
void show_during(GlbBuffer& buffer, GlbScene& scene, int node, const std::vector<double>& times, std::size_t pose) {
  std::vector<float> keys;
  std::vector<float> scales;
  const auto add = [&](double time, float scale) {
    keys.push_back(static_cast<float>(time));
    scales.insert(scales.end(), 3, scale);
  };
  if (pose > 0) add(times.front(), 0);
  add(times[pose], 1);
  if (pose + 1 < times.size()) add(times[pose + 1], 0);
  const int values = buffer.add(std::span<const float>(scales), kGlbVectors, GlbTarget::kNone);
  scene.animate(node, "scale", scene.add_times(buffer, keys), values, Interpolation::kStep);
}

} // namespace

int add_mesh_sequence(GlbBuffer& buffer, GlbScene& scene, const BlendedMesh& mesh, int material,
                      const GlbMeshSettings& settings) {
  const bool quantize = settings.quantize && !settings.draco;
  const GlbBox box = quantize ? cube_of_all(mesh) : GlbBox{};
  const int above = scene.add_node(box.node());
  const std::vector<double>& times = mesh.times();
  Json primitive;
  Json children = Json::array();
  for (std::size_t i = 0; i < times.size(); ++i) {
    const std::vector<Eigen::Vector3f> points = mesh.points(i);
    const MeshAttributes attributes(mesh.still(numbers_of(points)),
                                    settings.quantize ? VertexOrder::kDrawing : VertexOrder::kGiven);
    if (settings.draco) {
      primitive = draco_primitive(buffer, attributes);
    } else if (i == 0) {
      primitive = plain_primitive(buffer, attributes, quantize, box);
    } else {
      primitive["attributes"]["POSITION"] = add_positions(buffer, attributes.positions, quantize, box);
    }
    primitive["material"] = material;
    const std::string name = mesh.name + " " + std::to_string(i + 1);
    const int number = scene.add_mesh({{"name", name}, {"primitives", {primitive}}});
    const float scale = i == 0 ? 1 : 0;
    children.push_back(scene.add_node({{"name", name}, {"mesh", number}, {"scale", {scale, scale, scale}}}));
    if (times.size() > 1) show_during(buffer, scene, children.back(), times, i);
  }
  scene.nodes[static_cast<std::size_t>(above)]["name"] = mesh.name;
  scene.nodes[static_cast<std::size_t>(above)]["children"] = std::move(children);
  return above;
}

} // namespace kinora::formats
