// Where the nodes of a deforming layer are in one view: correspondences by projection, and Levenberg–Marquardt on the
// energy of DeformingProblem, coarse to fine.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "tracking/rigid/residuals.h"
#include "tracking/solver/deforming_problem.h"

namespace kinora::tracking {

/// Textures that a point of the model is known by; NaN where it is not.
struct PointTexture {
  std::array<float, LayerView::kLevels> last; ///< as the last view showed it, per level
  float fused;                                ///< of the canonical model; compared at the finest level
  std::uint8_t direction;                     ///< of the canonical normal: points of one direction are lit alike
};

struct DeformingAlignmentConfig {
  static constexpr std::size_t kStages = 3;
  double rigidity = 0.1;           ///< standard deviation of a neighbour's place, in units of the nodes' spacing
  double prior_sigma = 0.05;       ///< metres
  double photometric_weight = 0.3; ///< neighbouring pixels are not independent: weight of a texture term
  double silhouette_weight = 1;    ///< weight of a point that the camera sees past, for a pixel off the silhouette
  double texture_sigma = TextureModel::kMinTextureSigma; ///< at least; log luminance
  double plane_gate = 0.1; ///< metres; measured surface farther away than this is another one
  /// Metres from a point to what it may be compared with, from the coarsest level to the finest.
  std::array<double, kStages> gates{0.10, 0.06, 0.04};
  int rigid_iterations = 4;
  std::array<int, kStages> iterations{1, 1, 5}; ///< at most, from the coarsest level to the finest
  int damping_attempts = 4;                     ///< at a step that lowers the energy
  double min_decrease = 0.005;                  ///< share of the energy that a step saves if another is to follow it
  int pcg_iterations = 40;
  double pcg_tolerance = 1e-2;
};

struct DeformingAlignment {
  motion::NodeStates nodes; ///< canonical (relative to the origin) to camera
  std::vector<double>
      energies; ///< of each try: before, after, before, after …; within a pair correspondences are the same
  std::vector<double> seen; ///< for each node, share of the points it carries that lie on measured surface
};

/// How well node states explain a view.
struct DeformingQuality {
  std::size_t on_label = 0;              ///< points that face the camera and fall on a measured pixel of the label
  std::size_t inliers = 0;               ///< of these, within 3σ + 5 mm and 45°
  std::size_t free_space_violations = 0; ///< points off the label where the camera sees past them
  double texture_correlation = 0;        ///< of image and fused texture; 0 if there is too little texture to tell
  double inlier_share() const {
    return on_label > 0 ? static_cast<double>(inliers) / static_cast<double>(on_label) : 0.0;
  }
  double free_space_share() const {
    if (free_space_violations == 0) return 0;
    return static_cast<double>(free_space_violations) / static_cast<double>(on_label + free_space_violations);
  }
};

/// Refines `start`; nodes that nothing holds stay near `prior`, and go where `binding` (one pull for each node, or
/// none) draws them: the less, the more of their points lie on measured surface. Energy never rises from a step that is
/// taken. `spacing`: of the nodes, metres. `rigid_first`: all nodes are moved as one body before they are let go.
/// Deterministic for any number of threads.
DeformingAlignment align_deforming(const LayerModel& model, std::span<const PointTexture> textures,
                                   const LayerView& view, const motion::NodeStates& start,
                                   const motion::NodeStates& prior, double spacing,
                                   const DeformingAlignmentConfig& config = {},
                                   std::span<const NodeTarget> binding = {});

/// One rigid motion of all nodes that brings the model nearer to the view; correspondences within `gate` metres.
motion::NodeStates align_rigidly(const LayerModel& model, std::span<const PointTexture> textures, const LayerView& view,
                                 const motion::NodeStates& start, int level, double gate, int iterations,
                                 const DeformingAlignmentConfig& config = {});

DeformingQuality evaluate_deformation(const LayerModel& model, std::span<const PointTexture> textures,
                                      const LayerView& view, const motion::NodeStates& states);

/// Finds what each point is compared with at `pose`: the plane of the pixel that it falls on, and its textures; or,
/// where the camera sees past it, the plane through the camera and the nearest rim of the silhouette. What has turned
/// away from the camera has only the latter.
/// Exposed for tests.
void associate(const LayerModel& model, std::span<const PointTexture> textures, const LayerView& view,
               const motion::LayerPose& pose, int level, double gate, const DeformingAlignmentConfig& config,
               std::vector<DataTerm>& terms);

} // namespace kinora::tracking
