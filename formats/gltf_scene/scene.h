// An animated scene of triangles in memory, as glTF has it: nodes, meshes, skins, morph targets, animations, cameras.
// Metres; axes as the file has them (glTF: y up). Source: Khronos, "glTF 2.0 Specification" (2021).
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "core/image.h"

namespace kinora::formats {

struct SceneNode {
  std::string name;
  int parent = -1; ///< stands before this node in Scene::nodes; −1: none
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();
  Eigen::Affine3d matrix = Eigen::Affine3d::Identity(); ///< besides: of nodes that say a matrix instead
  std::vector<double> weights;                          ///< of its mesh's morph targets
};

struct SceneMaterial {
  Eigen::Vector3f base = Eigen::Vector3f::Ones(); ///< linear light
  int image = -1;                                 ///< in Scene::images; −1: none
  std::size_t texture_coordinates = 0;            ///< which set
};

/// Triangles of one material. Lists of attributes are empty, or as long as `positions`.
struct ScenePrimitive {
  std::vector<Eigen::Vector3f> positions;
  std::vector<Eigen::Vector2f> texture_coordinates; ///< shares of the picture from its upper left corner; it repeats
  std::vector<Eigen::Vector3f> colors;              ///< linear light
  std::vector<std::array<std::uint32_t, 4>> joints; ///< in the skin's list
  std::vector<Eigen::Vector4f> joint_weights;
  std::vector<std::vector<Eigen::Vector3f>> morph_targets; ///< displacements
  std::vector<std::uint32_t> indices;                      ///< three per triangle, each below positions.size()
  SceneMaterial material;
};

struct SceneSkin {
  std::vector<int> joints; ///< nodes
  std::vector<Eigen::Matrix4d> inverse_bind;
};

/// A mesh where a node puts it: what gets a label of its own.
struct SceneThing {
  std::string name;
  int node = 0;
  int mesh = 0;
  int skin = -1;
  bool deforms = false; ///< by a skin that moves, or morph targets
  bool moves = false;   ///< its node does
};

struct SceneCamera {
  std::string name;
  int node = 0;
  double vertical_angle = 0; ///< of the field of view, radians
};

enum class ScenePath { kTranslation, kRotation, kScale, kWeights };
enum class SceneInterpolation { kLinear, kStep, kCubic };

/// One quantity of one node over time.
struct SceneTrack {
  int node = 0;
  ScenePath path = ScenePath::kTranslation;
  SceneInterpolation interpolation = SceneInterpolation::kLinear;
  std::vector<double> times;  ///< increasing, at least one
  std::vector<double> values; ///< `width` per time; cubic: thrice that (tangent in, value, tangent out)
  std::size_t width = 3;      ///< rotation: x y z w

  /// At a time, clamped to the track. Rotations are not of unit length yet.
  std::vector<double> at(double time) const;
};

struct SceneAnimation {
  std::string name;
  std::vector<SceneTrack> tracks;
  double duration = 0;
};

struct Scene {
  std::vector<SceneNode> nodes; ///< parents before their children
  std::vector<std::vector<ScenePrimitive>> meshes;
  std::vector<SceneSkin> skins;
  std::vector<SceneThing> things;
  std::vector<SceneCamera> cameras;
  std::vector<SceneAnimation> animations;
  std::vector<ColorImage> images; ///< sRGB, 3 channels
};

/// Where the nodes are, and how far meshes are morphed, at one time.
class ScenePose {
public:
  /// `animation`: null: as the file stands.
  ScenePose(const Scene& scene, const SceneAnimation* animation, double time);

  const Eigen::Affine3d& node_to_world(int node) const { return to_world_[static_cast<std::size_t>(node)]; }
  /// The vertices of a thing's primitive in the world.
  std::vector<Eigen::Vector3f> vertices(const SceneThing& thing, const ScenePrimitive& primitive) const;

private:
  const Scene* scene_;
  std::vector<SceneNode> nodes_; ///< as they are now
  std::vector<Eigen::Affine3d> to_world_;
};

/// Fills in what moves: SceneThing::deforms and moves.
void find_motion(Scene& scene, const SceneAnimation* animation);

} // namespace kinora::formats
