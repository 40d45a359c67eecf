// Where a rigid model is in one view: point-to-plane distances and texture together, by Levenberg–Marquardt.
// Source: Gelfand et al., "Geometrically Stable Sampling for the ICP Algorithm", 3DIM 2003 (weak directions are small
// eigenvalues of the information with rotations scaled to metres).
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "core/se3.h"
#include "tracking/rigid/contour.h"
#include "tracking/rigid/residuals.h"

namespace kinora::tracking {

struct AlignmentConfig {
  int coarsest_level = 2;           ///< of the texture, from 2 to 0: how far from the solution it may start
  double degenerate_share = 0.01;   ///< a direction is weak if its information is below this share of what the same
                                    ///< points would give along their normals
  double texture_tolerance = 0.003; ///< metres; texture that fixes a direction to this supports it, whatever depth says
  double nearly_degenerate = 3;     ///< times that information, from depth and texture: below, the rim takes part too
  double contour_tolerance = 0.003; ///< metres; a rim that fixes a direction to this supports it, if it has
  double contour_degenerate_share = 0.05; ///< this share of what it would give along its normals
  double unseen_cost = 1; ///< of a point where the view shows nothing, to the most that a point can cost: an object's
                          ///< are lost by a wrong pose, a room's come and go with every motion of the camera
  double photometric_weight = 0.3; ///< neighbouring pixels are not independent: weight of the texture term
  double contour_weight = 0.3;     ///< likewise
};

struct Alignment {
  SE3 model_to_camera = SE3::Identity();
  /// How the data support each direction about the pivot, ascending; 1/m².
  Twist eigenvalues = Twist::Zero();
  Eigen::Matrix<double, 6, 6> directions = Eigen::Matrix<double, 6, 6>::Identity(); ///< columns: eigenvectors
  int degenerate_directions = 0; ///< the first so many were left to the prior
  std::size_t geometric_terms = 0;
  std::size_t photometric_terms = 0;
  int iterations = 0;
};

/// An earlier view's rim, carried by the model, and that of the view.
struct ContourPair {
  std::vector<ContourPoint> earlier; ///< places in the model
  ContourMap now;
};
/// Makes it when it is asked for; may return null, and must return the same each time.
using ContourSource = std::function<const ContourPair*()>;

/// Refines `start`. Where depth and texture leave directions open, `contours` (may be empty) take part. Directions that
/// the data leave open follow `prior` (both model to camera). With no usable point the result is the prior with six
/// weak directions. Deterministic; thread-safe.
Alignment align(std::span<const ModelPoint> points, const LayerView& view, const SE3& start, const SE3& prior,
                const ContourSource& contours = {}, const AlignmentConfig& config = {});

/// How firmly depth and texture hold a pose, each by itself, as align() weighs them in its last stage: information
/// about the step that leads to exp_se3(step) · model_to_camera. Deterministic; thread-safe.
struct PoseInformation {
  Eigen::Matrix<double, 6, 6> depth;
  Eigen::Matrix<double, 6, 6> texture;
};
PoseInformation information_at(std::span<const ModelPoint> points, const LayerView& view, const SE3& model_to_camera,
                               const AlignmentConfig& config = {});

/// Solves information · step = −gradient. Directions in which `support` (symmetric) has an eigenvalue below
/// `degenerate_below` are taken from `toward_prior` (a step); the others are solved for, their diagonal damped by the
/// factor 1 + damping. Finite for every finite input.
struct DampedStep {
  Twist step;
  Twist eigenvalues; ///< of the support, ascending
  Eigen::Matrix<double, 6, 6> directions;
  int degenerate_directions;
};
DampedStep solve_with_prior(const Eigen::Matrix<double, 6, 6>& information, const Eigen::Matrix<double, 6, 6>& support,
                            const Twist& gradient, const Twist& toward_prior, double degenerate_below, double damping);

} // namespace kinora::tracking
