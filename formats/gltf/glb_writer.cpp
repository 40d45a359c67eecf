#include "gltf/glb_writer.h"

#include <algorithm>
#include <cmath>

#include "common/files.h"
#include "common/mesh_fault.h"
#include "common/pictures.h"
#include "core/error.h"
#include "core/image_codec.h"
#include "core/jpeg_writer.h"
#include "gltf/mesh_sequence.h"
#include "gltf/morph_mesh.h"

namespace kinora::formats {
namespace {

using Json = nlohmann::json;

/// The scene's first node: from x right, y down, z forward to x right, y up, z backward.
constexpr int kRootNode = 0;
const std::vector<int> kHalfTurnAboutX = {1, 0, 0, 0};

constexpr int kLinearFilter = 9729, kMipmapFilter = 9987, kClamp = 33071; // OpenGL's numbers

Json joint_node(const std::string& name, const JointTrack& track) {
  const std::vector<float>& q = track.rotations();
  const std::vector<float>& t = track.translations();
  return {{"name", name},
          {"rotation", std::vector<float>(q.begin(), q.begin() + 4)},
          {"translation", std::vector<float>(t.begin(), t.begin() + 3)}};
}

/// From row by row to column by column.
std::vector<float> columns_of(const float* matrices, std::size_t count) {
  std::vector<float> columns(16 * count);
  for (std::size_t m = 0; m < count; ++m)
    for (std::size_t i = 0; i < 16; ++i) columns[16 * m + i] = matrices[16 * m + 4 * (i % 4) + i / 4];
  return columns;
}

/// A skinned mesh's own node does not count: what brings stored positions back is in the joints' matrices.
void unpack_in_joints(const GlbBox& box, std::vector<float>& inverse_bind) {
  for (std::size_t m = 0; m < inverse_bind.size(); m += 16) {
    float* matrix = inverse_bind.data() + m;
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t c = 0; c < 3; ++c) matrix[12 + row] += matrix[4 * c + row] * box.offset[c];
      for (std::size_t c = 0; c < 3; ++c) matrix[4 * c + row] *= box.scale;
    }
  }
}

} // namespace

GlbWriter::GlbWriter(std::filesystem::path path, const GlbSettings& settings)
    : path_(std::move(path)), settings_(settings),
      buffer_(path_, settings.compression == Compression::kMeshopt ? GlbPacking::kMeshopt : GlbPacking::kPlain) {
  if (settings.bending == Bending::kMorph && settings.compression == Compression::kDraco)
    throw Error(ErrorCode::kUsage,
                "Draco packs no morph targets; take -O compression=meshopt, or -O animation=sequence");
  write_file(path_, {});
}

void GlbWriter::refuse(const std::string& what) const { throw Error(ErrorCode::kUsage, path_.string() + ": " + what); }

void GlbWriter::add(const KinoraMesh& mesh) {
  if (posed_) refuse("all meshes must come before the first pose");
  if (const std::string fault = fault_of(mesh); !fault.empty())
    refuse(std::string("the mesh ") + (mesh.name != nullptr ? mesh.name : "without a name") +
           " cannot be written: " + fault);
  const int material = texture_material(mesh);
  MeshInstance instance{mesh.name, -1, mesh.joint_indices != nullptr, {}, {}, {}, {}, {}, material, {}};
  instance.tracks.resize(mesh.joint_count);
  if (instance.skinned && settings_.bending != Bending::kSkin) {
    instance.blended.emplace(mesh);
  } else {
    GlbMesh stored = add_mesh(buffer_, mesh, material, mesh_settings());
    instance.mesh = scene_.add_mesh(std::move(stored.entry));
    instance.box = stored.box;
    if (instance.skinned) instance.inverse_bind = columns_of(mesh.inverse_bind, mesh.joint_count);
    if (instance.skinned) unpack_in_joints(instance.box, instance.inverse_bind);
  }
  instances_.push_back(std::move(instance));
}

int GlbWriter::texture_material(const KinoraMesh& mesh) {
  Json material = {{"name", std::string(mesh.name) + " as seen"},
                   {"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 1}}},
                   {"extensions", {{"KHR_materials_unlit", Json::object()}}}};
  if (mesh.texture.data != nullptr) {
    const ColorImage picture = color_of(mesh.texture);
    const bool is_jpeg = settings_.jpeg_quality > 0;
    const std::vector<std::byte> bytes = is_jpeg ? encode_jpeg(picture, settings_.jpeg_quality) : encode_png(picture);
    material["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", images_.size()}};
    images_.push_back({{"name", mesh.name},
                       {"mimeType", is_jpeg ? "image/jpeg" : "image/png"},
                       {"bufferView", buffer_.add_bytes(bytes)}});
  }
  materials_.push_back(std::move(material));
  return static_cast<int>(materials_.size()) - 1;
}

void GlbWriter::pose(const KinoraMeshPose& pose) {
  posed_ = true;
  if (pose.mesh >= instances_.size()) refuse("a pose is for a mesh that is not there");
  MeshInstance& instance = instances_[pose.mesh];
  if (pose.joint_count != instance.tracks.size() || pose.joint_count == 0)
    refuse("a pose has not as many joints as its mesh " + instance.name);
  const auto time = static_cast<float>(pose.time);
  if (!(time >= 0) || (!instance.times.empty() && !(time > instance.times.back())))
    refuse("the times of the poses of " + instance.name + " are negative or do not increase");
  instance.times.push_back(time);
  instance.hidden.push_back(is_hidden(pose));
  if (instance.blended) {
    instance.blended->add(pose);
  } else {
    for (std::size_t j = 0; j < pose.joint_count; ++j) instance.tracks[j].add(pose.joints[j]);
  }
}

/// The joints' rotations or translations, one joint after another in one view.
void GlbWriter::animate_joints(const MeshInstance& instance, int first_node, bool rotations) {
  std::vector<std::size_t> moving;
  std::vector<float> values;
  for (std::size_t j = 0; j < instance.tracks.size(); ++j) {
    const JointTrack& track = instance.tracks[j];
    if (!(rotations ? track.rotates() : track.moves())) continue;
    moving.push_back(j);
    const std::vector<float>& all = rotations ? track.rotations() : track.translations();
    values.insert(values.end(), all.begin(), all.end());
  }
  if (moving.empty()) return;
  const bool in_shorts = rotations && settings_.quantize;
  std::vector<std::int16_t> shorts;
  if (in_shorts) {
    for (const float v : values) shorts.push_back(static_cast<std::int16_t>(std::lround(32767 * v)));
  }
  const GlbElements& elements = in_shorts ? kGlbRotations : rotations ? kGlbQuaternions : kGlbVectors;
  const std::size_t stride = in_shorts ? 8 : rotations ? 16 : 12;
  const int view = buffer_.add_view(
      in_shorts ? std::as_bytes(std::span<const std::int16_t>(shorts)) : std::as_bytes(std::span<const float>(values)),
      stride, GlbTarget::kNone, rotations || !settings_.quantize ? GlbFilter::kNone : GlbFilter::kExponential);
  const std::size_t times = instance.times.size();
  for (std::size_t i = 0; i < moving.size(); ++i) {
    const int output = buffer_.add_accessor(view, i * times * stride, times, elements);
    scene_.animate(first_node + static_cast<int>(moving[i]), rotations ? "rotation" : "translation",
                   scene_.add_times(buffer_, instance.times), output, settings_.interpolation);
  }
}

void GlbWriter::animate(const MeshInstance& instance, int first_node) {
  animate_joints(instance, first_node, true);
  animate_joints(instance, first_node, false);
}

std::vector<std::string> GlbWriter::extensions(bool required) const {
  std::vector<std::string> names;
  if (!required) names.emplace_back("KHR_materials_unlit");
  if (settings_.compression == Compression::kDraco) {
    names.emplace_back("KHR_draco_mesh_compression");
  } else if (settings_.quantize) {
    names.emplace_back("KHR_mesh_quantization");
  }
  if (settings_.compression == Compression::kMeshopt) names.emplace_back("EXT_meshopt_compression");
  return names;
}

Json GlbWriter::skin_of(MeshInstance& instance, Json& root_children) {
  Json joints = Json::array();
  for (std::size_t j = 0; j < instance.tracks.size(); ++j) {
    joints.push_back(scene_.add_node(joint_node(instance.name + " joint " + std::to_string(j), instance.tracks[j])));
    root_children.push_back(joints.back());
  }
  const int bind = buffer_.add(std::span<const float>(instance.inverse_bind), kGlbMatrices, GlbTarget::kNone);
  return {{"name", instance.name}, {"joints", std::move(joints)}, {"inverseBindMatrices", bind}};
}

int GlbWriter::add_blended(const MeshInstance& instance) {
  if (settings_.bending == Bending::kSequence)
    return add_mesh_sequence(buffer_, scene_, *instance.blended, instance.material, mesh_settings());
  return add_morph_mesh(buffer_, scene_, *instance.blended, instance.material,
                        {settings_.max_shapes, settings_.quantize, settings_.interpolation});
}

void GlbWriter::place(MeshInstance& instance, Json& skins, Json& scene_nodes, Json& root_children) {
  const auto first_node = static_cast<int>(scene_.nodes.size());
  if (instance.blended) {
    root_children.push_back(add_blended(instance));
    return;
  }
  animate(instance, first_node);
  if (instance.skinned) {
    // Only the joints place a skinned mesh: its own node stands beside the root, where nothing could be mistaken.
    skins.push_back(skin_of(instance, root_children));
    scene_nodes.push_back(
        scene_.add_node({{"name", instance.name}, {"mesh", instance.mesh}, {"skin", skins.size() - 1}}));
    return;
  }
  root_children.push_back(first_node);
  Json own = instance.box.node();
  const bool is_boxed = !own.empty();
  own["name"] = instance.name;
  own["mesh"] = instance.mesh;
  if (instance.tracks.empty()) {
    scene_.add_node(std::move(own));
    return;
  }
  Json joint = joint_node(instance.name, instance.tracks[0]);
  if (is_boxed) {
    joint["children"] = {first_node + 1};
    own["name"] = instance.name + " mesh";
  } else {
    joint["mesh"] = instance.mesh;
  }
  scene_.add_node(std::move(joint));
  if (is_boxed) scene_.add_node(std::move(own));
}

/// The nodes get one above them that has no size while the mesh is hidden.
void GlbWriter::hang_on_shown_node(const MeshInstance& instance, Json& children) {
  std::vector<float> times;
  std::vector<float> scales;
  for (std::size_t i = 0; i < instance.times.size(); ++i) {
    if (i > 0 && instance.hidden[i] == instance.hidden[i - 1]) continue;
    times.push_back(instance.times[i]);
    scales.insert(scales.end(), 3, instance.hidden[i] ? 0.0F : 1.0F);
  }
  const std::vector<float> first(scales.begin(), scales.begin() + 3);
  const int node = scene_.add_node({{"name", instance.name + " shown"}, {"scale", first}, {"children", children}});
  const int values = buffer_.add(std::span<const float>(scales), kGlbVectors, GlbTarget::kNone);
  if (times.size() > 1) scene_.animate(node, "scale", scene_.add_times(buffer_, times), values, Interpolation::kStep);
  children = Json::array({node});
}

void GlbWriter::finish() {
  if (instances_.empty()) throw Error(ErrorCode::kFailure, path_.string() + ": no mesh was written");
  scene_.add_node({{"name", "kinora"}, {"rotation", kHalfTurnAboutX}});
  Json root_children = Json::array();
  Json scene_nodes = Json::array({kRootNode});
  Json skins = Json::array();
  for (MeshInstance& instance : instances_) {
    if (!instance.tracks.empty() && instance.times.empty())
      refuse("the mesh " + instance.name + " has joints and no pose");
    Json children = Json::array();
    place(instance, skins, scene_nodes, children);
    const bool is_ever_hidden =
        std::find(instance.hidden.begin(), instance.hidden.end(), true) != instance.hidden.end();
    if (is_ever_hidden) hang_on_shown_node(instance, children);
    root_children.insert(root_children.end(), children.begin(), children.end());
  }
  if (!root_children.empty()) scene_.nodes[kRootNode]["children"] = root_children;
  Json gltf = {{"asset", {{"version", "2.0"}, {"generator", "Kinora"}}},
               {"extensionsUsed", extensions(false)},
               {"scene", 0},
               {"scenes", {{{"name", "clip"}, {"nodes", scene_nodes}}}},
               {"nodes", scene_.nodes},
               {"meshes", scene_.meshes},
               {"materials", materials_}};
  if (const auto required = extensions(true); !required.empty()) gltf["extensionsRequired"] = required;
  if (!images_.empty()) {
    gltf["images"] = images_;
    gltf["samplers"] = {
        {{"magFilter", kLinearFilter}, {"minFilter", kMipmapFilter}, {"wrapS", kClamp}, {"wrapT", kClamp}}};
    for (std::size_t i = 0; i < images_.size(); ++i) gltf["textures"].push_back({{"source", i}, {"sampler", 0}});
  }
  for (const auto& [name, value] : facts_) gltf["asset"]["extras"][name] = value;
  if (!skins.empty()) gltf["skins"] = skins;
  if (!scene_.animation["channels"].empty()) gltf["animations"] = {scene_.animation};
  buffer_.describe(gltf);
  write_glb(path_, gltf, buffer_.bytes());
}

} // namespace kinora::formats
