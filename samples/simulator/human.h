// A person of MakeHuman's free mesh, moved by motion capture.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "core/se3.h"
#include "motion_capture.h"

namespace kinora::simulator {

enum class Part : std::uint8_t { kSkin, kShirt, kTrousers, kSkirt, kShoes, kHair, kEye };

struct HumanOptions {
  std::vector<std::pair<std::string, double>> targets; ///< of shape: name without ending, and how much of it
  bool long_sleeves = false;
  bool skirt = false;
  double hair_length = 0.05; ///< metres, from the middle of the head down
};

/// Where all of it is at one time. World: metres, y up.
struct HumanPose {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<SE3> bones; ///< from rest to the world
  std::vector<Eigen::Vector3d> joints;
};

/// Metres, y up, facing z; at rest the arms hang obliquely.
class Human {
public:
  /// `data`: the folder with base.obj.gz, targets and rigs. Throws Error(kCorruptInput).
  Human(const std::filesystem::path& data, const HumanOptions& options);

  const std::vector<Eigen::Vector3d>& rest() const { return rest_; }
  const std::vector<std::array<int, 3>>& faces() const { return faces_; }
  const std::vector<Part>& parts() const { return parts_; } ///< of each face
  const std::vector<std::string>& bone_names() const { return bone_names_; }
  const std::vector<int>& bone_parents() const { return bone_parents_; }
  std::size_t bone(const std::string& name) const;
  const Eigen::Vector3d& rest_joint(std::size_t bone) const { return bone_heads_[bone]; } ///< where the bone begins

  /// As the motion has it at `seconds`, with the hips in the motion's own place times the ratio of legs.
  HumanPose pose(const MotionCapture& motion, double seconds) const;

private:
  void read_mesh(const std::filesystem::path& path);
  void shape(const std::filesystem::path& folder, const HumanOptions& options);
  void read_rig(const std::filesystem::path& folder);
  void dress(const HumanOptions& options);

  struct Group {
    std::string name;
    std::vector<std::array<int, 3>> faces;
  };
  std::vector<Group> groups_;
  std::vector<Eigen::Vector3d> rest_;
  std::vector<std::array<int, 3>> faces_;
  std::vector<Part> parts_;
  std::vector<std::string> bone_names_; ///< parents first
  std::vector<int> bone_parents_;
  std::vector<Eigen::Vector3d> bone_heads_;
  std::vector<std::vector<std::pair<int, double>>> weights_; ///< of each vertex
};

} // namespace kinora::simulator
