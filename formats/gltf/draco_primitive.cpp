#include "gltf/draco_primitive.h"

#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>

#include "core/error.h"

namespace kinora::formats {
namespace {

/// Each vertex has one entry in each attribute.
class MeshToPack {
public:
  explicit MeshToPack(const MeshAttributes& mesh) {
    packed_.set_num_points(static_cast<std::uint32_t>(mesh.vertex_count()));
    packed_.SetNumFaces(mesh.faces.size() / 3);
    for (std::uint32_t f = 0; f < mesh.faces.size() / 3; ++f) {
      draco::Mesh::Face face;
      for (std::uint32_t k = 0; k < 3; ++k) face[k] = draco::PointIndex(mesh.faces[3 * f + k]);
      packed_.SetFace(draco::FaceIndex(f), face);
    }
  }

  template <class Value>
  int add(const std::vector<Value>& values, draco::GeometryAttribute::Type type, draco::DataType data_type,
          int components, bool normalized) {
    const std::size_t stride = sizeof(Value) * static_cast<std::size_t>(components);
    draco::GeometryAttribute attribute;
    attribute.Init(type, nullptr, static_cast<std::int8_t>(components), data_type, normalized,
                   static_cast<std::int64_t>(stride), 0);
    const int id = packed_.AddAttribute(attribute, true, packed_.num_points());
    for (std::uint32_t v = 0; v < packed_.num_points(); ++v)
      packed_.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(v),
                                               values.data() + v * static_cast<std::size_t>(components));
    return id;
  }
  const draco::Mesh& mesh() const { return packed_; }

private:
  draco::Mesh packed_;
};

} // namespace

nlohmann::json draco_primitive(GlbBuffer& buffer, const MeshAttributes& mesh) {
  using Attribute = draco::GeometryAttribute;
  struct Named {
    const char* name;
    int id;
    GlbElements elements;
  };
  MeshToPack packed(mesh);
  std::vector<Named> attributes;
  attributes.push_back(
      {"POSITION", packed.add(mesh.positions, Attribute::POSITION, draco::DT_FLOAT32, 3, false), kGlbPositions});
  if (!mesh.normals.empty())
    attributes.push_back(
        {"NORMAL", packed.add(mesh.normals, Attribute::NORMAL, draco::DT_FLOAT32, 3, false), kGlbVectors});
  if (!mesh.colors.empty())
    attributes.push_back({"COLOR_0", packed.add(mesh.colors, Attribute::COLOR, draco::DT_UINT16, 4, true), kGlbShares});
  if (!mesh.texture.empty())
    attributes.push_back(
        {"TEXCOORD_0", packed.add(mesh.texture, Attribute::TEX_COORD, draco::DT_FLOAT32, 2, false), kGlbTextureFloats});
  if (!mesh.joints.empty()) {
    attributes.push_back(
        {"JOINTS_0", packed.add(mesh.joints, Attribute::GENERIC, draco::DT_UINT16, 4, false), kGlbNumbers});
    attributes.push_back(
        {"WEIGHTS_0", packed.add(mesh.weights, Attribute::GENERIC, draco::DT_UINT16, 4, true), kGlbShares});
  }
  draco::ExpertEncoder encoder(packed.mesh());
  constexpr int kPositionBits = 14, kTextureBits = 12, kNormalBits = 8;
  for (const Named& attribute : attributes) {
    const auto type = packed.mesh().attribute(attribute.id)->attribute_type();
    if (type == Attribute::POSITION) encoder.SetAttributeQuantization(attribute.id, kPositionBits);
    if (type == Attribute::TEX_COORD) encoder.SetAttributeQuantization(attribute.id, kTextureBits);
    if (type == Attribute::NORMAL) encoder.SetAttributeQuantization(attribute.id, kNormalBits);
  }
  encoder.SetSpeedOptions(3, 3);
  encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
  encoder.SetTrackEncodedProperties(true);
  draco::EncoderBuffer out;
  const draco::Status status = encoder.EncodeToBuffer(&out);
  if (!status.ok()) throw Error(ErrorCode::kFailure, std::string("Draco cannot pack the mesh: ") + status.error_msg());
  nlohmann::json extension = {{"bufferView", buffer.add_bytes(std::as_bytes(std::span(out.data(), out.size())))},
                              {"attributes", nlohmann::json::object()}};
  nlohmann::json accessors = nlohmann::json::object();
  for (const Named& attribute : attributes) {
    extension["attributes"][attribute.name] = packed.mesh().attribute(attribute.id)->unique_id();
    accessors[attribute.name] = buffer.add_unstored_accessor(encoder.num_encoded_points(), attribute.elements);
    if (attribute.elements.with_range) buffer.add_range(std::span<const float>(mesh.positions), 3, 3);
  }
  const int faces = buffer.add_unstored_accessor(3 * encoder.num_encoded_faces(), kGlbIndices);
  return {{"attributes", std::move(accessors)},
          {"indices", faces},
          {"extensions", {{"KHR_draco_mesh_compression", std::move(extension)}}}};
}

} // namespace kinora::formats
