#include "tracking/body/body_pose_database.h"

#include <cmath>

namespace kinora::tracking {

double BodyPoseDatabase::distance(const Entry& a, const Entry& b) {
  double sum = 0;
  for (std::size_t j = 0; j < a.rotations.size(); ++j) {
    const double angle = 2 * std::acos(std::min(1.0, std::abs(a.rotations[j].dot(b.rotations[j]))));
    sum += angle * angle;
  }
  return std::sqrt(sum / static_cast<double>(kJoints));
}

void BodyPoseDatabase::add(const BodyPose& pose, const Bones& bones, const Eigen::Vector3d& centre) {
  Entry entry{pose, {}};
  entry.pose.root.translation() -= centre;
  for (std::size_t j = 0; j < bones.size(); ++j) entry.rotations[j] = Eigen::Quaterniond(bones[j].linear());
  entries_.add(std::move(entry), distance);
}

std::vector<BodyPose> BodyPoseDatabase::about(const Eigen::Vector3d& centre) const {
  std::vector<BodyPose> poses;
  for (const Entry& entry : entries_.entries()) {
    poses.push_back(entry.pose);
    poses.back().root.translation() += centre;
  }
  return poses;
}

} // namespace kinora::tracking
