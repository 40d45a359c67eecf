// What one view says of a posed body: which part a measured point lies on, and which of the body's points the camera
// sees, sees past, or cannot see.
// Source: Tagliasacchi et al., "Robust Articulated-ICP for Real-Time Hand Tracking", SGP 2015.
#pragma once

#include <cmath>
#include <vector>

#include "core/robust_cost.h"
#include "tracking/body/body_model.h"
#include "tracking/body/joint_observations.h"
#include "tracking/body/pose_prior.h"
#include "tracking/view/layer_view.h"

namespace kinora::tracking {

struct BodyEnergyConfig {
  double sigma = 0.02;         ///< metres: cloth, muscle and hair against rounded cones
  double cutoff = 0.06;        ///< metres: what lies farther away counts little (GemanMcClure)
  double patch = 0.04;         ///< metres: errors nearer to each other are not independent
  double normal_length = 0.05; ///< metres that a right angle between both normals is worth
  double contact_weight = 4;   ///< of a hand that holds something, in patches
  double slack = 0.02;         ///< share by which the energy may rise in a step
  double small_step = 2e-3;    ///< metres and radians: a step below is the last
  PosePriorConfig poses;
  DetectedJointsConfig detected;
};

/// A measured point of the person, in the camera.
struct MeasuredPoint {
  Eigen::Vector3d position, normal;
  double weight; ///< area across the ray in patches
};

/// What a view says. `view` must outlive it.
struct BodyEvidence {
  const LayerView* view;
  std::vector<MeasuredPoint> points;
  std::vector<JointObservation> joints = {}; ///< if a detector has looked for them
};
/// Points: at most about `max_points`, evenly over the picture.
BodyEvidence gather_evidence(const LayerView& view, std::size_t max_points, const BodyEnergyConfig& config);

/// A body in the camera.
struct BodyState {
  BodyPose pose;
  Shape shape = Shape::Zero();
};

/// Parts with the way from the camera into their bones: what is asked many times.
class BodyInCamera {
public:
  explicit BodyInCamera(const BodyState& state);
  const PosedBody& body() const { return body_; }
  const SE3& bone(std::size_t part) const { return body_.bones[body_parts()[part].bone]; }
  const SE3& to_bone(std::size_t part) const { return camera_to_bone_[part]; }

  /// How a part explains a point: squared metres that count both distance and normals, and the surface there.
  struct Match {
    explicit Match(double max_cost) : cost(max_cost), root(std::sqrt(max_cost)) {}
    double cost;
    double root;            ///< of the cost
    ClosestSurface surface; ///< in the part's bone
    int part = -1;          ///< −1: nothing is near enough
    double squared_distance() const { return part < 0 ? cost : surface.distance * surface.distance; }
  };
  /// Replaces `best` if the part explains the point at less cost.
  void match(std::size_t part, const MeasuredPoint& point, double normal_length, Match& best) const;

private:
  PosedBody body_;
  std::array<SE3, kBodyParts> camera_to_bone_;
  std::array<Eigen::Vector3d, kBodyParts> centres_;
};

/// What the view says about a point of the body's surface.
enum class Visibility {
  kUnseen,   ///< it faces away or lies outside the picture
  kSeen,     ///< the view shows the person there
  kHidden,   ///< behind something, be it the person
  kFreeSpace ///< violated: the camera sees past it
};
struct SampleResidual {
  Visibility visibility = Visibility::kUnseen;
  double value = 0;          ///< metres by which it violates free space
  Eigen::Vector3d direction; ///< unit: value grows by direction · movement
  double weight = 0;         ///< area across the ray in patches
};
SampleResidual sample_residual(const BodyInCamera& body, const BodySample& sample, const LayerView& view,
                               const BodyEnergyConfig& config);

/// Of distances in metres.
inline GemanMcClure robust_cost(const BodyEnergyConfig& config) { return {config.sigma, config.cutoff}; }

} // namespace kinora::tracking
