// Camera poses from text: TUM's groundtruth.txt, 3DMatch's .pose.txt and Open3D's trajectory.log.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/se3.h"

namespace kinora::formats {

/// Poses over time, from lines "time tx ty tz qx qy qz qw" (camera-to-world, metres, seconds).
class Trajectory {
public:
  /// Lines that cannot be used (no eight finite numbers, a quaternion that is not of unit length) are left out with a
  /// warning that counts them. Throws Error(kCorruptInput) if the file cannot be read.
  static Trajectory read(const std::filesystem::path& path, std::vector<std::string>& warnings);

  /// The pose at a time: between two poses at most 0.1 s apart along the screw, else the nearest if it is within
  /// `tolerance` seconds, else nothing.
  std::optional<SE3> at(double time, double tolerance) const;

private:
  struct Pose {
    double time;
    SE3 camera_to_world;
  };
  std::vector<Pose> poses_; ///< in order of time
};

/// A 4×4 camera-to-world matrix. Throws Error(kCorruptInput) naming the file unless it is a finite rigid transform.
SE3 read_pose_file(const std::filesystem::path& path);

/// Frame by frame three numbers, which nobody needs, and such a matrix. Throws as read_pose_file does.
std::vector<SE3> read_trajectory_log(const std::filesystem::path& path);

} // namespace kinora::formats
