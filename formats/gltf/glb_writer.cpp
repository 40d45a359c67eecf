#include "gltf/glb_writer.h"

#include "common/files.h"
#include "core/error.h"
#include "gltf/mesh_data.h"

namespace kinora::formats {
namespace {

using Json = nlohmann::json;

/// The scene's first node: from x right, y down, z forward to x right, y up, z backward.
constexpr int kRootNode = 0;
const std::vector<int> kHalfTurnAboutX = {1, 0, 0, 0};

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

} // namespace

GlbWriter::GlbWriter(std::filesystem::path path, const GlbSettings& settings)
    : path_(std::move(path)), settings_(settings) {
  write_file(path_, {});
}

void GlbWriter::refuse(const std::string& what) const { throw Error(ErrorCode::kUsage, path_.string() + ": " + what); }

void GlbWriter::add(const KinoraMesh& mesh) {
  if (posed_) refuse("all meshes must come before the first pose");
  if (const std::string fault = fault_of(mesh); !fault.empty())
    refuse(std::string("the mesh ") + (mesh.name != nullptr ? mesh.name : "without a name") +
           " cannot be written: " + fault);
  MeshInstance instance{mesh.name, static_cast<int>(meshes_.size()), mesh.joint_indices != nullptr, {}, {}, {}};
  if (instance.skinned) instance.inverse_bind = columns_of(mesh.inverse_bind, mesh.joint_count);
  instance.tracks.resize(mesh.joint_count);
  meshes_.push_back(add_mesh(buffer_, mesh));
  instances_.push_back(std::move(instance));
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
  for (std::size_t j = 0; j < pose.joint_count; ++j) instance.tracks[j].add(pose.joints[j]);
}

int GlbWriter::times_accessor(const std::vector<float>& times) {
  const auto [entry, is_new] = times_.try_emplace(times, 0);
  if (is_new) entry->second = buffer_.add(std::span<const float>(times), kGlbScalars, GlbTarget::kNone);
  return entry->second;
}

void GlbWriter::animate(const MeshInstance& instance, int first_node, Json& animation) {
  const auto channel = [&](std::size_t joint, const char* path, const std::vector<float>& values,
                           const GlbElements& elements) {
    const int output = buffer_.add(std::span<const float>(values), elements, GlbTarget::kNone);
    animation["channels"].push_back({{"sampler", animation["samplers"].size()},
                                     {"target", {{"node", first_node + static_cast<int>(joint)}, {"path", path}}}});
    animation["samplers"].push_back(
        {{"input", times_accessor(instance.times)},
         {"output", output},
         {"interpolation", settings_.interpolation == Interpolation::kStep ? "STEP" : "LINEAR"}});
  };
  for (std::size_t j = 0; j < instance.tracks.size(); ++j) {
    const JointTrack& track = instance.tracks[j];
    if (track.rotates()) channel(j, "rotation", track.rotations(), kGlbQuaternions);
    if (track.moves()) channel(j, "translation", track.translations(), kGlbVectors);
  }
}

Json GlbWriter::skin_of(MeshInstance& instance, Json& nodes, Json& root_children) {
  Json joints = Json::array();
  for (std::size_t j = 0; j < instance.tracks.size(); ++j) {
    joints.push_back(nodes.size());
    root_children.push_back(nodes.size());
    nodes.push_back(joint_node(instance.name + " joint " + std::to_string(j), instance.tracks[j]));
  }
  const int bind = buffer_.add(std::span<const float>(instance.inverse_bind), kGlbMatrices, GlbTarget::kNone);
  return {{"name", instance.name}, {"joints", std::move(joints)}, {"inverseBindMatrices", bind}};
}

void GlbWriter::finish() {
  if (instances_.empty()) throw Error(ErrorCode::kFailure, path_.string() + ": no mesh was written");
  Json nodes = Json::array({{{"name", "kinora"}, {"rotation", kHalfTurnAboutX}}});
  Json root_children = Json::array();
  Json scene_nodes = Json::array({kRootNode});
  Json skins = Json::array();
  Json animation = {{"name", "clip"}, {"channels", Json::array()}, {"samplers", Json::array()}};
  for (MeshInstance& instance : instances_) {
    if (!instance.tracks.empty() && instance.times.empty())
      refuse("the mesh " + instance.name + " has joints and no pose");
    const auto first_node = static_cast<int>(nodes.size());
    animate(instance, first_node, animation);
    if (instance.skinned) {
      // Only the joints place a skinned mesh: its own node stands beside the root, where nothing could be mistaken.
      skins.push_back(skin_of(instance, nodes, root_children));
      scene_nodes.push_back(nodes.size());
      nodes.push_back({{"name", instance.name}, {"mesh", instance.mesh}, {"skin", skins.size() - 1}});
    } else {
      root_children.push_back(first_node);
      nodes.push_back(instance.tracks.empty() ? Json{{"name", instance.name}}
                                              : joint_node(instance.name, instance.tracks[0]));
      nodes.back()["mesh"] = instance.mesh;
    }
  }
  if (!root_children.empty()) nodes[kRootNode]["children"] = root_children;
  Json gltf = {{"asset", {{"version", "2.0"}, {"generator", "Kinora"}}},
               {"extensionsUsed", {"KHR_materials_unlit"}},
               {"scene", 0},
               {"scenes", {{{"name", "clip"}, {"nodes", scene_nodes}}}},
               {"nodes", nodes},
               {"meshes", meshes_},
               {"materials",
                {{{"name", "as seen"},
                  {"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 1}}},
                  {"extensions", {{"KHR_materials_unlit", Json::object()}}}}}}};
  if (!skins.empty()) gltf["skins"] = skins;
  if (!animation["channels"].empty()) gltf["animations"] = {animation};
  buffer_.describe(gltf);
  write_file(path_, glb_file(gltf, buffer_.bytes(), path_.string()));
}

} // namespace kinora::formats
