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

std::vector<std::uint16_t> box_positions(const std::vector<float>& positions, const GlbBox& box) {
  std::vector<std::uint16_t> shares;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    shares.push_back(whole_share((positions[i] - box.offset[i % 3]) / box.scale));
    if (i % 3 == 2) shares.push_back(0);
  }
  return shares;
}

} // namespace

nlohmann::json GlbBox::node() const {
  nlohmann::json node = nlohmann::json::object();
  if (scale != 1) node["scale"] = {scale, scale, scale};
  if (offset != std::array<float, 3>{}) node["translation"] = offset;
  return node;
}

GlbBox cube_around(std::span<const float> positions) {
  GlbBox box;
  std::array<float, 3> high{};
  std::copy_n(positions.begin(), 3, box.offset.begin());
  std::copy_n(positions.begin(), 3, high.begin());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    box.offset[i % 3] = std::min(box.offset[i % 3], positions[i]);
    high[i % 3] = std::max(high[i % 3], positions[i]);
  }
  box.scale = 0;
  for (std::size_t a = 0; a < 3; ++a) box.scale = std::max(box.scale, high[a] - box.offset[a]);
  if (!(box.scale > 0)) box.scale = 1;
  return box;
}

int add_positions(GlbBuffer& buffer, const std::vector<float>& positions, bool quantize, const GlbBox& box) {
  if (!quantize) return buffer.add(std::span<const float>(positions), kGlbPositions, GlbTarget::kVertices);
  const std::vector<std::uint16_t> shares = box_positions(positions, box);
  return buffer.add(std::span<const std::uint16_t>(shares), kGlbBoxPositions, GlbTarget::kVertices);
}

nlohmann::json plain_primitive(GlbBuffer& buffer, const MeshAttributes& mesh, bool quantize, const GlbBox& box) {
  const auto add = [&buffer]<class Value>(const std::vector<Value>& values, const GlbElements& elements) {
    return buffer.add(std::span<const Value>(values), elements, GlbTarget::kVertices);
  };
  nlohmann::json attributes = nlohmann::json::object();
  attributes["POSITION"] = add_positions(buffer, mesh.positions, quantize, box);
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

GlbMesh add_mesh(GlbBuffer& buffer, const KinoraMesh& mesh, int material, const GlbMeshSettings& settings) {
  const MeshAttributes attributes(mesh, settings.quantize ? VertexOrder::kDrawing : VertexOrder::kGiven);
  GlbMesh added;
  if (settings.quantize && !settings.draco) added.box = cube_around(attributes.positions);
  nlohmann::json primitive = settings.draco ? draco_primitive(buffer, attributes)
                                            : plain_primitive(buffer, attributes, settings.quantize, added.box);
  primitive["material"] = material;
  added.entry = {{"name", mesh.name}, {"primitives", {std::move(primitive)}}};
  return added;
}

} // namespace kinora::formats
