// Meshes that move, as one GLB file.
// Source: Khronos Group, "glTF 2.0 Specification" (2021); KHR_materials_unlit, KHR_mesh_quantization,
// EXT_meshopt_compression, KHR_draco_mesh_compression.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "common/blended_mesh.h"
#include "common/facts.h"
#include "gltf/glb_buffer.h"
#include "gltf/glb_scene.h"
#include "gltf/joint_track.h"
#include "gltf/mesh_data.h"
#include "kinora/plugin.h"

namespace kinora::formats {

enum class Compression { kNone, kMeshopt, kDraco };

/// How a mesh that bends does so.
enum class Bending {
  kSkin,
  kMorph,   ///< morph_mesh.h
  kSequence ///< mesh_sequence.h
};

struct GlbSettings {
  Interpolation interpolation = Interpolation::kLinear;
  Compression compression = Compression::kNone; ///< Draco packs geometry alone; meshopt animation too
  bool quantize = true;                         ///< 16-bit positions, texture coordinates and rotations
  int jpeg_quality = 88;                        ///< of textures; 0: PNG
  Bending bending = Bending::kSkin;
  std::size_t max_shapes = 24; ///< of kMorph, 1 to kMaxShapes
};

/// One node per mesh, with an unlit material and a texture or vertex colours. A mesh with one joint and no weights is a
/// node that is animated; one with weights has a skin, whose joints are animated nodes, or bends as the settings say. A
/// mesh that is hidden at times hangs on one more node, which has no size then. glTF's axes are x right, y up, z
/// towards the viewer: a root node turns Kinora's by half a turn about x. The file is written by finish().
class GlbWriter {
public:
  /// Checks that the file can be written. Throws Error(kUnwritableOutput).
  GlbWriter(std::filesystem::path path, const GlbSettings& settings);

  /// The asset's "extras".
  void describe(Facts facts) { facts_ = std::move(facts); }
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
    GlbBox box;                      ///< of its positions
    std::vector<float> inverse_bind; ///< of a skin, column by column
    std::vector<float> times;
    std::vector<bool> hidden;       ///< of each time
    std::vector<JointTrack> tracks; ///< one per joint
    int material;
    std::optional<BlendedMesh> blended; ///< instead of all that is stored, if it does not bend by a skin
  };

  GlbMeshSettings mesh_settings() const { return {settings_.quantize, settings_.compression == Compression::kDraco}; }
  void place(MeshInstance& instance, nlohmann::json& skins, nlohmann::json& scene_nodes, nlohmann::json& root_children);
  void hang_on_shown_node(const MeshInstance& instance, nlohmann::json& children);
  int add_blended(const MeshInstance& instance);
  nlohmann::json skin_of(MeshInstance& instance, nlohmann::json& root_children);
  void animate(const MeshInstance& instance, int first_node);
  void animate_joints(const MeshInstance& instance, int first_node, bool rotations);
  int texture_material(const KinoraMesh& mesh);
  std::vector<std::string> extensions(bool required) const;
  [[noreturn]] void refuse(const std::string& what) const;

  std::filesystem::path path_;
  GlbSettings settings_;
  Facts facts_;
  GlbBuffer buffer_;
  GlbScene scene_;
  std::vector<MeshInstance> instances_;
  nlohmann::json materials_ = nlohmann::json::array();
  nlohmann::json images_ = nlohmann::json::array();
  bool posed_ = false;
};

} // namespace kinora::formats
