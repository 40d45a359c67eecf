// A user's own body: a person's surface at rest with its joints, from a file that holds what SMPL's files hold.
// Source: Loper et al., "SMPL: A Skinned Multi-Person Linear Model", SIGGRAPH Asia 2015, sections 3 and 4 (rest shape,
// skinning weights, joint regressor), and the array names of the files that its authors hand out.
#pragma once

#include <array>
#include <filesystem>
#include <vector>

#include <Eigen/Core>

namespace kinora::ingest {

/// SMPL's joints, in its order; hands that a model has beyond these are not looked at.
constexpr std::size_t kBodyMeshJoints = 22;
constexpr std::array<int, kBodyMeshJoints> kBodyMeshParents = {-1, 0, 0, 0, 1,  2,  3,  4,  5,  6,  7,
                                                               8,  9, 9, 9, 12, 13, 14, 16, 17, 18, 19};

/// Metres; x to the person's left, y up, z forward; arms stretched to the sides.
struct BodyMesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<std::array<std::size_t, 3>> faces; ///< of vertices, counter-clockwise from outside
  std::vector<std::size_t> bone;                 ///< of each vertex: the joint that carries most of it
  std::array<Eigen::Vector3d, kBodyMeshJoints> joints;
};

/// Reads `v_template` (V×3), `f` (F×3), `weights` (V×J), `J_regressor` (J×V) and `kintree_table` (2×J) from an `.npz`
/// file; `shapedirs` and `posedirs` may stand beside them and are not needed. Safe for untrusted input. Throws
/// Error(kCorruptInput), naming file, array and remedy: for damage, pickled objects (a sparse regressor), numbers that
/// are not finite, shapes that do not go together, other joints than SMPL's, and a body that is not of a person's size.
BodyMesh read_body_mesh(const std::filesystem::path& path);

} // namespace kinora::ingest
