// A copy of a mesh with the poses of its joints, and where they put its points.
#pragma once

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "core/image.h"
#include "core/se3.h"
#include "kinora/plugin.h"

namespace kinora::formats {

/// Whether the mesh is not to be seen from this pose on.
inline bool is_hidden(const KinoraMeshPose& pose) {
  return pose.struct_size >= sizeof(KinoraMeshPose) && pose.hidden != 0;
}

enum class MeshMotion { kStill, kRigid, kBlended };

class BlendedMesh {
public:
  /// The mesh has no fault. Points of one that follows a single joint are in the joint's space from here on.
  explicit BlendedMesh(const KinoraMesh& mesh);

  void add(const KinoraMeshPose& pose);

  MeshMotion motion() const;
  std::size_t joint_count() const { return inverse_bind_.size(); }
  const std::vector<double>& times() const { return times_; } ///< seconds, of the poses
  /// Whether the mesh is not to be seen from a pose on to the next.
  bool hidden(std::size_t pose) const { return hidden_[pose]; }
  bool is_ever_hidden() const { return std::find(hidden_.begin(), hidden_.end(), true) != hidden_.end(); }
  /// Joint to world, of a rigid mesh.
  SE3 transform(std::size_t pose) const;
  /// In the world, of a blended mesh: the sum of KinoraMesh. Else as they are given.
  std::vector<Eigen::Vector3f> points(std::size_t pose) const;
  /// Without joints and normals at other positions, x y z of each vertex; it points to them and into this.
  KinoraMesh still(const float* at) const;

  std::string name;
  std::vector<Eigen::Vector3f> positions;
  std::vector<std::array<std::uint32_t, 3>> faces;
  std::vector<std::array<std::uint8_t, 3>> colors; ///< empty if there is a texture
  std::vector<Eigen::Vector2f> texture_coordinates;
  ColorImage texture;

private:
  struct Joint {
    std::array<float, 4> rotation; // w x y z
    std::array<float, 3> translation;
  };
  std::vector<Eigen::Matrix4f> inverse_bind_;
  std::vector<std::array<std::uint16_t, 4>> joint_numbers_;
  std::vector<std::array<float, 4>> weights_;
  std::vector<double> times_;
  std::vector<bool> hidden_;  // of each pose
  std::vector<Joint> joints_; // of all poses, one after another
};

} // namespace kinora::formats
