// What is expected of a body before a view is looked at: limits, everyday poses, people's measures, and where it was.
#pragma once

#include <vector>

#include "tracking/body/hand_contact.h"

namespace kinora::tracking {

/// Sum of squares in units of their deviations, its gradient, and its Gauss–Newton Hessian by pose and shape.
struct BodyEquations {
  double energy = 0;
  Eigen::Matrix<double, kDof, 1> gradient;
  Eigen::Matrix<double, kDof, kDof> hessian;
};
/// What is expected before the view is looked at. Everyday poses, limits of joints and the spread of people's measures
/// about mean proportions are always expected.
struct BodyPrior {
  BodyState state;
  PoseStep pose_precision = PoseStep::Zero(); ///< one over variances
  std::vector<HandContact> hands;             ///< that hold something
  Eigen::Matrix<double, kMeasures, kMeasures> shape_precision = Eigen::Matrix<double, kMeasures, kMeasures>::Zero();
};

void add_prior(const BodyState& state, const BodyPrior& prior, const PosePriorConfig& poses, BodyEquations& equations);

/// Energy of the pose's angles alone: limits and everyday poses.
double angle_energy(const Angles& angles, const PosePriorConfig& poses);

/// What an arm that nobody sees would rather not do: enter trunk or thighs, or put the wrist behind the back.
struct ArmPenalty {
  std::size_t part; ///< of the arm
  PartPoint point;
  double value;             ///< in deviations
  Eigen::Vector3d gradient; ///< of the value by the point's movement, per metre
};
std::vector<ArmPenalty> arm_penalties(const BodyInCamera& body);
double energy_of(const std::vector<ArmPenalty>& reluctances);

} // namespace kinora::tracking
