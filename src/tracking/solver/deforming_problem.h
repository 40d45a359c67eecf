// What one view says about the motion of a deforming layer: the energy that the solver brings down, and its
// derivatives. Sources: Newcombe et al., "DynamicFusion", CVPR 2015 (point to plane, as rigid as possible); Innmann et
// al., "VolumeDeform", ECCV 2016 (texture).
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/robust_cost.h"
#include "motion/skinning/layer_pose.h"
#include "tracking/model/surface_graph.h"
#include "tracking/solver/arap_term.h"
#include "tracking/solver/block_system.h"
#include "tracking/solver/data_term.h"
#include "tracking/solver/jacobian_products.h"
#include "tracking/view/layer_view.h"

namespace kinora::tracking {

/// A place that something beside the view would have a node at.
struct NodeTarget {
  Eigen::Vector3d position = Eigen::Vector3d::Zero(); ///< in the camera
  double scale = 0;                                   ///< one over the standard deviation, metres; zero: no pull
};

struct ProblemWeights {
  double rigidity_sigma = 0.005;  ///< metres that two nodes may disagree about a neighbour's place
  double prior_sigma = 0.05;      ///< metres from the predicted place of a node; holds what nothing else does
  double huber = kHuberThreshold; ///< standard deviations from which on all terms grow linearly
};

/// The layer's part that does not change while a view is solved. All references must outlive the problem.
struct LayerModel {
  std::span<const Eigen::Vector3d> nodes; ///< canonical, relative to the origin
  std::span<const GraphEdge> edges;
  std::span<const motion::SkinnedPoint> points;
};

/// Thread-safe to read.
class DeformingProblem {
public:
  DeformingProblem(const LayerModel& model, const LayerView& view, const ProblemWeights& weights);

  const LayerModel& model() const { return model_; }
  /// Of the systems; known from the first linearise() on.
  const BlockPattern& pattern() const { return pattern_; }
  /// One for each point; to be filled before energy() and linearise().
  std::vector<DataTerm>& terms() { return terms_; }
  /// Pyramid level that textures are compared at.
  void set_level(int level) { level_ = level; }
  /// Where the prior would have the nodes.
  void set_prior(const motion::NodeStates& prior);
  /// Where a skeleton would have them: one pull for each node, or none.
  void set_binding(std::span<const NodeTarget> binding) { binding_.assign(binding.begin(), binding.end()); }
  void set_rigidity_sigma(double sigma) { weights_.rigidity_sigma = sigma; }

  /// Half the sum of squares of all terms, in standard deviations, with Huber's cost.
  /// `pose`, here and below: the model's points under some states of its nodes.
  double energy(const motion::LayerPose& pose) const;
  /// Gauss–Newton system about `pose`, weights as Huber has them there; and the energy there. Same bits for any
  /// number of threads. It stays until the next one.
  const BlockSystem& linearise(const motion::LayerPose& pose, double& energy);
  /// The system of one twist for all nodes, about `pivot`, of the points' terms alone.
  void linearise_rigid(const motion::LayerPose& pose, const Eigen::Vector3d& pivot, Matrix6d& information,
                       Twist& gradient) const;

private:
  struct EdgeIncidence {
    int edge;
    std::uint32_t block;
  };

  void find_pattern();
  std::span<const PointIncidence> incidences_of(std::size_t node) const {
    return std::span(point_incidences_)
        .subspan(point_incidences_begin_[node], point_incidences_begin_[node + 1] - point_incidences_begin_[node]);
  }
  std::span<PointIncidence> incidences_of(std::size_t node) {
    return std::span(point_incidences_)
        .subspan(point_incidences_begin_[node], point_incidences_begin_[node + 1] - point_incidences_begin_[node]);
  }
  double jacobians_at(const motion::LayerPose& pose);
  double targets_energy(const motion::NodeStates& states) const;
  void add_points(std::size_t node);
  void add_arap_term(std::size_t node, const motion::NodeStates& states);
  void add_target(std::size_t node, const NodeTarget& target, const motion::NodeStates& states);
  double target_energy(std::span<const NodeTarget> targets, const motion::NodeStates& states) const;

  LayerModel model_;
  const LayerView& view_;
  ProblemWeights weights_;
  int level_ = 0;
  BlockPattern pattern_;
  std::vector<DataTerm> terms_;
  std::vector<NodeTarget> prior_;
  std::vector<NodeTarget> binding_;
  BlockSystem system_;
  std::unique_ptr<PointJacobians[]> jacobians_;     ///< one for each point, as of the last linearise()
  std::vector<PointIncidence> point_incidences_;    ///< of each node, one after the other
  std::vector<std::size_t> point_incidences_begin_; ///< for each node, and one more at the end
  std::vector<ArapEdge> edges_;
  std::vector<ArapResiduals> arap_residuals_; ///< one for each edge, as of the last linearise()
  std::vector<std::vector<EdgeIncidence>> edge_incidences_;
};

} // namespace kinora::tracking
