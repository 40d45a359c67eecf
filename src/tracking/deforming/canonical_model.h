// The canonical model of a deforming layer: its surface, fused in one pose, and the deformation graph that moves it.
// Sources: Newcombe et al., "DynamicFusion", CVPR 2015; Jiang et al., "Instant-NVR", CVPR 2023, eq. 1–2; another
// canonical pose: Dou et al., "Fusion4D", SIGGRAPH 2016, sec. 5 (key volumes), of which this keeps one at a time.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "motion/skinning/blended_motion.h"
#include "tracking/deforming/graph_growth.h"
#include "tracking/deforming/new_components.h"
#include "tracking/model/brick_influences.h"
#include "tracking/model/brick_surface.h"
#include "tracking/model/surface_graph.h"
#include "tracking/tsdf/tsdf.h"

namespace kinora::tracking {

/// How the graph and the model grow. Lengths in units of the nodes' spacing, but where metres are said.
struct GraphGrowthConfig {
  double weight_radius = 1.1;
  double influence_radius = 2.5;      ///< so that a surface between nodes, and what lies before it, moves with them
  double sample_spacing = 1.0 / 3;    ///< grid of the thinned surface
  float min_views = 2.5F;             ///< that a surface must have been seen in before it gets nodes
  double max_surface_distance = 0.03; ///< metres from the model to what is fused
};

struct CanonicalModelConfig {
  double voxel_size = 0;   ///< metres; 0: from the sensor's noise and the footprint of a pixel at the layer
  double node_spacing = 0; ///< metres; 0: so that the first view's surface gets about `first_nodes`
  std::size_t first_nodes = 300;
  std::size_t max_nodes = 700;
  int fuse_interval = 4; ///< frames from one to the next that is fused where the surface was seen often
  GraphGrowthConfig growth;
  NewPieceConfig pieces;
};

/// Places are relative to origin(), metres. Thread-safe to read. Same calls, same bits, for any number of threads.
class CanonicalModel {
public:
  /// Of the layer's first view, in the pose it has there. Nothing if nothing of what is measured can be fused: it is
  /// nearer than any sensor measures.
  static std::optional<CanonicalModel> from_view(const LayerView& view, const SE3& camera_to_world,
                                                 const CanonicalModelConfig& config = {});

  const Eigen::Vector3d& origin() const { return volume_.origin(); } ///< in the world
  double spacing() const { return spacing_; }                        ///< of the nodes, metres
  const std::vector<Eigen::Vector3d>& nodes() const { return nodes_; }
  const std::vector<GraphEdge>& edges() const { return edges_.edges(); } ///< which nodes hold each other
  std::span<const SurfacePoint> surface() const { return surface_.points(); }
  std::span<const motion::Influence> skin() const { return surface_.skin(); } ///< for each point of the surface
  /// The graph at its place in the world.
  std::shared_ptr<const motion::DeformationGraph> graph_in_world() const;

  SE3 origin_to_camera(const SE3& camera_to_world) const;
  /// `transforms`: of each node, canonical to world, both relative to the origin.
  motion::NodeStates states(const SE3& origin_to_camera, std::span<const SE3> transforms) const;

  /// Fuses a view in which the nodes have these states (canonical to camera). Surface without nodes gets some, and so
  /// do pieces that have kept apart from the model for long enough. `frame`: a number that counts frames up; which
  /// parts of the surface rest goes by turns.
  GraphGrowth fuse(const LayerView& view, motion::NodeStates states, std::size_t frame);

  /// Takes another canonical pose, to which `pose` leads each node. What is known goes along, each piece of surface
  /// with its own nodes, and edges are found anew.
  void set_canonical_pose(std::span<const SE3> pose);

private:
  CanonicalModel(const CanonicalModelConfig& config, TsdfVolume volume);

  std::vector<std::size_t> add_components(const LayerView& view, motion::NodeStates& states,
                                          TsdfVolume::CanonicalMap& positions);
  std::vector<motion::Influence> grow_graph(float min_weight, std::span<const std::uint8_t> changed);
  std::vector<SurfaceSample> unsupported_samples(float min_weight, std::span<const std::uint8_t> changed) const;
  motion::Influence influence_at(const Eigen::Vector3d& position) const;
  void update_graph();
  void connect_graph(std::size_t old, float min_weight);
  void update_skinning();
  void warp_volume(std::span<const Eigen::Vector3d> old_nodes, std::span<const SE3> pose);

  CanonicalModelConfig config_;
  double spacing_ = 0;
  TsdfVolume volume_;
  std::vector<Eigen::Vector3d> nodes_;
  std::shared_ptr<const motion::DeformationGraph> graph_; ///< over the nodes
  SurfaceEdges edges_;
  BrickInfluences influences_;
  BrickSurface surface_;
  float unit_weight_ = 0; ///< of a surface point seen once
  PersistentComponents components_;
};

} // namespace kinora::tracking
