// Motion capture from a BVH file.
// Source: Meredith and Maddock, "Motion Capture File Formats Explained", 2001 (Biovision hierarchical data).
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/se3.h"

namespace kinora::simulator {

/// A skeleton's joints over time. Lengths are the file's own.
class MotionCapture {
public:
  /// A BVH file, packed with gzip or not. Throws Error(kCorruptInput), naming it.
  explicit MotionCapture(const std::filesystem::path& path);

  bool has(const std::string& joint) const { return index_.contains(joint); }
  /// From the joint's axes at rest, which are the file's, to those at `seconds`; between frames along the shortest arc.
  Eigen::Quaterniond rotation(const std::string& joint, double seconds) const;
  /// Of the root.
  Eigen::Vector3d position(double seconds) const;
  /// Where `joint` is at rest, seen from the root.
  Eigen::Vector3d rest_position(const std::string& joint) const;

private:
  struct Joint {
    int parent;
    Eigen::Vector3d rest;
    std::string rotation_axes; ///< in the order in which the file gives them: "ZXY"
  };
  Eigen::Quaterniond local_rotation(std::size_t joint, double seconds) const;

  std::vector<Joint> joints_;
  std::map<std::string, std::size_t> index_;
  double seconds_per_frame_ = 0;
  std::vector<std::vector<double>> frames_; ///< three numbers of the root's place, then three angles a joint
};

} // namespace kinora::simulator
