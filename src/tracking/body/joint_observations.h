// Joints that a detector has found in the picture draw the body: each lies somewhere on the ray of its pixel.
// Sources: Jiang et al., "Instant-NVR", CVPR 2023, eq. 2 (pose); Bogo et al., "Keep it SMPL", ECCV 2016 (robust
// distances to detected joints, weighted by their scores).
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/camera.h"
#include "core/robust_cost.h"
#include "ingest/frame/joint_detection.h"
#include "tracking/body/body_model.h"

namespace kinora::tracking {

struct DetectedJointsConfig {
  double weight = 2;      ///< of a joint of score 1, in patches of measured surface
  double sigma = 0.04;    ///< metres: where annotators see a joint, and where the model has it
  double cutoff = 0.12;   ///< metres: what lies farther away counts little (GemanMcClure)
  double min_score = 0.3; ///< joints below are not used
};
/// Of distances in metres, by a joint's weight.
inline GemanMcClure robust_cost(const DetectedJointsConfig& config) { return {config.sigma, config.cutoff}; }

/// A detected joint as the body is told of it.
struct JointObservation {
  std::size_t joint;   ///< by COCO's order (ingest::DetectedJointName)
  Eigen::Vector2d ray; ///< x and y of the ray of its pixel in the camera, where z is 1
  double weight;       ///< in patches
};
/// `joints` in pixels of `camera`.
std::vector<JointObservation> observe_joints(const ingest::DetectedJoints& joints, const Intrinsics& camera,
                                             const DetectedJointsConfig& config);

/// Where a detector's joint is on the body: at the origin of a part's bone, or at a point of the part's surface (of the
/// head).
struct Landmark {
  std::size_t part;
  std::optional<PartPoint> point;
};
const Landmark& landmark_of(std::size_t joint);
Eigen::Vector3d position_of(const Landmark& landmark, const PosedBody& body);

/// Metres that a place in the camera is beside the ray, at its own depth and across the optical axis: component i
/// grows by directions[i] · movement of the place.
struct RayDistance {
  explicit RayDistance(const Eigen::Vector3d& position, const Eigen::Vector2d& ray);
  std::array<Eigen::Vector3d, 2> directions;
  Eigen::Vector2d value;
};

/// The robust cost of its distance, by its weight.
double energy_of(const JointObservation& observed, const PosedBody& body, const DetectedJointsConfig& config);
/// Slope of that by the squared distance.
double loss_derivative(const JointObservation& observed, double squared, const DetectedJointsConfig& config);
/// Those that are near where the body has them, or near where they were found in the frame before (`before`): what is
/// found once and elsewhere is a mistake more often than not.
std::vector<JointObservation> consistent_observations(std::span<const JointObservation> observed,
                                                      std::span<const JointObservation> before,
                                                      const PosedBody& expected, const DetectedJointsConfig& config);

double energy_of(std::span<const JointObservation> observed, const PosedBody& body, const DetectedJointsConfig& config);

} // namespace kinora::tracking
