// Meshes that move, as one GLB file.
// Source: Khronos Group, "glTF 2.0 Specification" (2021); KHR_materials_unlit, KHR_mesh_quantization,
// EXT_meshopt_compression, KHR_draco_mesh_compression.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "gltf/glb_buffer.h"
#include "gltf/joint_track.h"
#include "gltf/mesh_data.h"
#include "kinora/plugin.h"

namespace kinora::formats {

enum class Interpolation { kLinear, kStep };
enum class Compression { kNone, kMeshopt, kDraco };

struct GlbSettings {
  Interpolation interpolation = Interpolation::kLinear;
  Compression compression = Compression::kNone; ///< Draco packs geometry alone; meshopt animation too
  bool quantize = true;                         ///< 16-bit positions, texture coordinates and rotations
  int jpeg_quality = 88;                        ///< of textures; 0: PNG
};

/// One node per mesh, with an unlit material and a texture or vertex colours. A mesh with one joint and no weights is a
/// node that is animated; one with weights has a skin, whose joints are animated nodes. glTF's axes are x right, y up,
/// z towards the viewer: a root node turns Kinora's by half a turn about x. The file is written by finish().
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
    GlbMesh stored;                  ///< where its positions are
    std::vector<float> inverse_bind; ///< of a skin, column by column
    std::vector<float> times;
    std::vector<JointTrack> tracks; ///< one per joint
  };

  nlohmann::json skin_of(MeshInstance& instance, nlohmann::json& nodes, nlohmann::json& root_children);
  void animate(const MeshInstance& instance, int first_node, nlohmann::json& animation);
  void animate_joints(const MeshInstance& instance, int first_node, bool rotations, nlohmann::json& animation);
  int texture_material(const KinoraMesh& mesh);
  nlohmann::json mesh_node(const MeshInstance& instance) const;
  std::vector<std::string> extensions(bool required) const;
  int times_accessor(const std::vector<float>& times);
  [[noreturn]] void refuse(const std::string& what) const;

  std::filesystem::path path_;
  GlbSettings settings_;
  GlbBuffer buffer_;
  nlohmann::json meshes_ = nlohmann::json::array();
  std::vector<MeshInstance> instances_;
  std::map<std::vector<float>, int> times_; ///< accessors: meshes normally share their times
  nlohmann::json materials_ = nlohmann::json::array();
  nlohmann::json images_ = nlohmann::json::array();
  bool posed_ = false;
};

} // namespace kinora::formats
