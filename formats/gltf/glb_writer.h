// Meshes that move, as one GLB file.
// Source: Khronos Group, "glTF 2.0 Specification" (2021); KHR_materials_unlit.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "gltf/glb_buffer.h"
#include "gltf/joint_track.h"
#include "kinora/plugin.h"

namespace kinora::formats {

enum class Interpolation { kLinear, kStep };

struct GlbSettings {
  Interpolation interpolation = Interpolation::kLinear;
};

/// One node per mesh, with an unlit material and vertex colours. A mesh with one joint and no weights is a node that is
/// animated; one with weights has a skin, whose joints are animated nodes. glTF's axes are x right, y up, z towards
/// the viewer: a root node turns Kinora's by half a turn about x. The file is written by finish().
class GlbWriter {
public:
  /// Checks that the file can be written. Throws Error(kUnwritableOutput).
  GlbWriter(std::filesystem::path path, const GlbSettings& settings);

  /// Throws Error(kUsage) if the mesh contradicts itself (numbers of vertices or joints that are out of range) or
  /// follows a pose.
  void add(const KinoraMesh& mesh);
  /// Throws Error(kUsage) if there is no such mesh, its joints are not as many, or time does not increase.
  void pose(const KinoraMeshPose& pose);
  /// Throws Error: kFailure without a mesh, kUnwritableOutput.
  void finish();

private:
  struct MeshInstance {
    std::string name;
    int mesh; ///< number in the file
    bool skinned;
    std::vector<float> inverse_bind; ///< of a skin, column by column
    std::vector<float> times;
    std::vector<JointTrack> tracks; ///< one per joint
  };

  nlohmann::json skin_of(MeshInstance& instance, nlohmann::json& nodes, nlohmann::json& root_children);
  void animate(const MeshInstance& instance, int first_node, nlohmann::json& animation);
  int times_accessor(const std::vector<float>& times);
  [[noreturn]] void refuse(const std::string& what) const;

  std::filesystem::path path_;
  GlbSettings settings_;
  GlbBuffer buffer_;
  nlohmann::json meshes_ = nlohmann::json::array();
  std::vector<MeshInstance> instances_;
  std::map<std::vector<float>, int> times_; ///< accessors: meshes normally share their times
  bool posed_ = false;
};

} // namespace kinora::formats
