#include "gltf/mesh_data.h"

#include <cmath>

#include "gltf/draco_primitive.h"
#include "gltf/mesh_attributes.h"

namespace kinora::formats {
namespace {

std::vector<std::int8_t> byte_normals(const std::vector<float>& normals) {
  std::vector<std::int8_t> bytes;
  for (std::size_t i = 0; i < normals.size(); ++i) {
    bytes.push_back(static_cast<std::int8_t>(std::lround(127 * std::clamp(normals[i], -1.0F, 1.0F))));
    if (i % 3 == 2) bytes.push_back(0);
  }
  return bytes;
}

/// Positions in a cube around them; fills in where it is.
std::vector<std::uint16_t> box_positions(const std::vector<float>& positions, GlbMesh& mesh) {
  std::array<float, 3> high{};
  std::copy_n(positions.begin(), 3, mesh.offset.begin());
  std::copy_n(positions.begin(), 3, high.begin());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    mesh.offset[i % 3] = std::min(mesh.offset[i % 3], positions[i]);
    high[i % 3] = std::max(high[i % 3], positions[i]);
  }
  mesh.scale = 0;
  for (std::size_t a = 0; a < 3; ++a) mesh.scale = std::max(mesh.scale, high[a] - mesh.offset[a]);
  if (!(mesh.scale > 0)) mesh.scale = 1;
  std::vector<std::uint16_t> places;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    places.push_back(whole_share((positions[i] - mesh.offset[i % 3]) / mesh.scale));
    if (i % 3 == 2) places.push_back(0);
  }
  return places;
}

nlohmann::json plain_primitive(GlbBuffer& buffer, const MeshAttributes& mesh, bool quantize, GlbMesh& added) {
  const auto add = [&buffer]<class Value>(const std::vector<Value>& values, const GlbElements& elements) {
    return buffer.add(std::span<const Value>(values), elements, GlbTarget::kVertices);
  };
  nlohmann::json attributes = nlohmann::json::object();
  attributes["POSITION"] =
      quantize ? add(box_positions(mesh.positions, added), kGlbBoxPositions) : add(mesh.positions, kGlbPositions);
  if (!mesh.normals.empty())
    attributes["NORMAL"] = quantize ? add(byte_normals(mesh.normals), kGlbByteNormals) : add(mesh.normals, kGlbVectors);
  if (!mesh.colors.empty()) attributes["COLOR_0"] = add(mesh.colors, kGlbShares);
  if (!mesh.texture.empty()) {
    std::vector<std::uint16_t> shares;
    for (const float v : mesh.texture) shares.push_back(whole_share(v));
    attributes["TEXCOORD_0"] = quantize ? add(shares, kGlbTexturePlaces) : add(mesh.texture, kGlbTextureFloats);
  }
  if (!mesh.joints.empty()) {
    attributes["JOINTS_0"] = add(mesh.joints, kGlbNumbers);
    attributes["WEIGHTS_0"] = add(mesh.weights, kGlbShares);
  }
  const int faces = buffer.add(std::span<const std::uint32_t>(mesh.faces), kGlbIndices, GlbTarget::kIndices);
  return {{"attributes", std::move(attributes)}, {"indices", faces}};
}

} // namespace

GlbMesh add_mesh(GlbBuffer& buffer, const KinoraMesh& mesh, int material, const GlbMeshSettings& settings) {
  const MeshAttributes attributes(mesh, settings.quantize ? VertexOrder::kDrawing : VertexOrder::kGiven);
  GlbMesh added;
  nlohmann::json primitive = settings.draco ? draco_primitive(buffer, attributes)
                                            : plain_primitive(buffer, attributes, settings.quantize, added);
  primitive["material"] = material;
  added.entry = {{"name", mesh.name}, {"primitives", {std::move(primitive)}}};
  return added;
}

} // namespace kinora::formats
