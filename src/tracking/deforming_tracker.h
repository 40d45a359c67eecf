// Follows one layer that bends through a capture, fuses what it sees of it, and grows its deformation graph.
// Sources: Newcombe et al., "DynamicFusion", CVPR 2015; Innmann et al., "VolumeDeform", ECCV 2016; Jiang et al.,
// "Instant-NVR", CVPR 2023, eq. 1–2; the body, if there is one, is fitted before the graph (layer_body.h).
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <vector>

#include "ingest/frame.h"
#include "tracking/brick_influences.h"
#include "tracking/brick_surface.h"
#include "tracking/deforming_alignment.h"
#include "tracking/deforming_config.h"
#include "tracking/deforming_selection.h"
#include "tracking/frame_memory.h"
#include "tracking/interaction.h"
#include "tracking/layer_body.h"
#include "tracking/motion.h"
#include "tracking/new_pieces.h"
#include "tracking/pose_library.h"
#include "tracking/surface_graph.h"
#include "tracking/tsdf.h"

namespace kinora::tracking {

struct DeformingTrackerConfig {
  double voxel_size = 0;   ///< metres; 0: from the sensor's noise and the footprint of a pixel at the layer
  double node_spacing = 0; ///< metres; 0: so that the first frame's surface gets about `first_nodes`
  std::size_t first_nodes = 300;
  std::size_t max_nodes = 700;
  std::size_t first_pixels = 150; ///< pixels with clean depth that the layer's first frame must have
  std::size_t min_pixels = 60;    ///< fewer: the deformation is held
  std::size_t max_points = 6000;  ///< model points used for alignment
  double min_inlier_share = 0.5;  ///< of the points that fall on the layer; below, the deformation is not believed
  double max_empty_share = 0.5;   ///< of the points in view, where the camera sees past them; above, likewise
  int held_frames = 30;           ///< unseen for longer: lost
  int fuse_interval = 4;          ///< frames from one to the next that is fused where the surface was seen often
  bool use_body = true;           ///< false: no skeleton is looked for
  bool use_objects = true;        ///< false: nothing is held
  bool use_searches = true;    ///< false: as predicted and aligned; limbs, texture and lost layers are not looked for
  double velocity_share = 0.8; ///< of the last motion that the next one is expected to repeat
  DeformingAlignmentConfig solver;
  LayerBodyConfig body;
  InteractionConfig interaction;
  double holding_sigma = 0.01; ///< metres, of a node beside the object that it holds
  DeformingSearchConfig search;
  LimbPlacementConfig limbs;
  BlockMatchingConfig flow;
  GraphGrowthConfig growth;
  TopologyChangeConfig topology;
  RelocalisationConfig relocalisation;
  BackwardSmoothingConfig backward;
};

/// One frame's answer.
struct DeformingTrackingResult {
  Health health = Health::kLost;
  std::size_t pixels = 0; ///< of the layer, with clean depth
  std::size_t nodes = 0;
  DeformingQuality quality;
};

/// Health: kTracked: the view supports the deformation; kHeld: too little is seen, the last one stays; kLost: it is
/// seen but not found, or unseen for long, or not yet seen at all. Only tracked frames are fused.
/// Not thread-safe. Same frames, same bits, for any number of threads.
class DeformingTracker {
public:
  explicit DeformingTracker(int label, const DeformingTrackerConfig& config = {});
  ~DeformingTracker();
  DeformingTracker(DeformingTracker&&) noexcept;
  DeformingTracker& operator=(DeformingTracker&&) noexcept;

  /// Frames in order of time. A frame without labels is the layer's as a whole. Throws Error(kFailure) if the frame's
  /// images differ in size. `objects`: those that the layer may hold, as they are in this frame.
  DeformingTrackingResult track(const ingest::Frame& frame, std::span<const NearbyObject> objects = {});

  /// How the layer has carried an object that it holds, in the world, since the last frame that found both: the rigid
  /// motion of the nodes that hold it and are seen, or else of those on a limb that is seen. Nothing if it holds none
  /// of this label, or none of these is seen.
  std::optional<SE3> carried(int label) const;

  int label() const { return label_; }
  /// Whether the layer has been seen at all; without, there is no motion.
  bool started() const { return volume_ != nullptr; }
  /// The motion over all frames so far. Canonical space = world at the layer's first frame, or at a later one in which
  /// surfaces are apart that touched before; the frames before the first are kLost and have that frame's deformation.
  /// Throws Error(kFailure) before the layer was seen.
  Motion motion() const;
  /// Nodes that were found late have moved, before that, as their neighbours did, which nobody saw. This follows them
  /// back through what is remembered (FrameMemory), so that they are where the camera could not see them. To
  /// be called after the last frame.
  void settle_past();
  /// Canonical model; nullptr before the layer's first frame.
  const TsdfVolume* model() const { return volume_.get(); }
  double node_spacing() const { return spacing_; }
  /// Which nodes of the motion's graph hold each other.
  const std::vector<GraphEdge>& edges() const { return edges_.edges(); }
  /// The skeleton beside the graph.
  const LayerBody& body() const { return body_; }

private:
  struct Past;
  struct Future;

  bool begin(const ingest::Frame& frame, const ObjectView& view);
  Health follow(const ingest::Frame& frame, const ObjectView& view, std::span<const NearbyObject> objects,
                DeformingTrackingResult& result);
  DeformingAlignment align_from_afar(const LayerModel& model, const DeformingSelection& selection,
                                     const ObjectView& view, NodeStates start, std::span<const NodePull> binding) const;
  std::vector<NodeStates> recalled(const ObjectView& view) const;
  DeformingAlignment align_recalled(const ObjectView& view, std::span<const NodePull> binding,
                                    DeformingAlignment best) const;
  double shown_share(const ObjectView& view, const NodeStates& states,
                     const std::function<bool(const Influence&)>& takes_part = nullptr) const;
  bool is_healthy(const DeformingQuality& quality) const;
  std::vector<SE3> predicted(double time) const;
  void follow_texture(const ObjectView& view, const SE3& world_to_camera, const NodeStates& then,
                      std::vector<SE3>& nodes) const;
  void place_layer(const ObjectView& view, const SE3& world_to_camera, std::vector<SE3>& nodes) const;
  void place_limbs(const ObjectView& view, const SE3& world_to_camera, std::vector<SE3>& nodes) const;
  void place_bones(std::span<const Joint> bones, std::span<const SE3> placed, const ObjectView& view,
                   const SE3& world_to_camera, std::vector<SE3>& nodes) const;
  std::vector<NodePull> pulls(const SE3& from_world, std::span<const NearbyObject> objects) const;
  std::vector<SE3> placed_by_bones() const;
  std::vector<GraphEdge> holding_edges(std::span<const NodePull> binding) const;
  SE3 relative_to_origin(const ingest::Frame& frame) const;
  NodeStates states_in(const SE3& world_to_camera, const std::vector<SE3>& nodes) const;
  void follow_back(std::size_t number, const ingest::Frame& frame, Future& future);
  void fuse(const ObjectView& view, NodeStates states);
  void learn_holds(std::vector<double> seen, std::span<const NearbyObject> objects);
  std::vector<NewPiece> lasting_pieces(const ObjectView& view, const TsdfVolume::Places& places);
  void adopt_pieces(const ObjectView& view, NodeStates& states, TsdfVolume::Places& places);
  std::vector<std::size_t> parted_nodes(std::span<const double> seen) const;
  std::vector<SE3> opened_pose() const;
  void take_pose_for_canonical(std::span<const std::size_t> parted);
  void carry_model(std::span<const Eigen::Vector3d> old_nodes, std::span<const SE3> pose);
  void renew_skin();
  std::vector<SurfaceSample> samples_beyond_nodes(float min_weight, std::span<const std::uint8_t> changed) const;
  void grow_graph(float min_weight, std::span<const std::uint8_t> changed);
  void connect_graph(std::size_t old, float min_weight);

  int label_;
  DeformingTrackerConfig config_;
  double spacing_ = 0;
  std::unique_ptr<TsdfVolume> volume_;
  std::vector<Eigen::Vector3d> nodes_; ///< canonical, relative to the volume's origin, as all that follows
  std::shared_ptr<const DeformationGraph> graph_;
  SurfaceEdges edges_;
  BrickInfluences influences_;
  BrickSurface surface_;
  float unit_weight_ = 0; ///< of a surface point seen once
  struct Record {
    std::vector<SE3> nodes; ///< canonical to world, both relative to the origin; empty before the first frame
    Health health = Health::kLost;
  };
  std::vector<Record> records_;
  FrameMemory memory_;              ///< of the frames of records_
  std::vector<std::size_t> births_; ///< for each node, the first record that is not a guess
  std::unique_ptr<Past> past_;
  PoseLibrary library_; ///< of frames of records_
  LayerBody body_;
  Interaction interaction_;
  std::map<int, std::size_t> met_; ///< by the object's label: the last record in which both were found
  std::vector<double> seen_;       ///< how much of each node the last frame shows; empty if the layer was not found
  int unseen_ = 0;
  struct SeenPiece {
    Eigen::Vector3d centroid; ///< in the camera
    int frames;               ///< in a row that have shown it
  };
  std::vector<SeenPiece> pieces_; ///< apart from the model in the last frame
};

} // namespace kinora::tracking
