// How a layer's mesh follows its motion: joints and weights.
#pragma once

#include <span>
#include <vector>

#include "host/mesh_writer.h"
#include "motion/motion.h"

namespace kinora::bake {

/// The joints of a mesh. Still: none. Rigid: one, at the middle of the mesh. Deforming: those nodes of the graph that
/// move a vertex, each with its origin at the node; weights are those of the graph's blending.
class Skinning {
public:
  /// Fills mesh.skin. Every vertex must be moved by at least one node (surface.h leaves others out).
  Skinning(const motion::Motion& motion, host::Mesh& mesh);

  bool moves() const { return !inverse_bind_.empty(); }
  /// Joint to world at a frame of the clip (clamped); empty if the layer is still.
  std::vector<SE3> joints_at(int frame) const;

  /// Meshes blend matrices, Kinora blends dual quaternions: how far apart the two put vertices, in metres.
  struct Difference {
    double mean = 0;
    double largest = 0;
  };
  /// Over some thousand vertices at these frames. Zero unless the layer deforms.
  Difference blending_difference(const host::Mesh& mesh, std::span<const int> frames) const;

private:
  motion::Motion motion_;
  std::vector<int> nodes_; // of the graph, one per joint
  std::vector<SE3> inverse_bind_;
};

} // namespace kinora::bake
