// What a synthetic capture folder knows of the truth, for `eval`; never read when encoding.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/image.h"

namespace kinora::evaluate {

/// A camera that the capture did not have, with what it would have seen at some frames.
struct NovelCamera {
  std::string name;
  Camera camera;           ///< in the clip's world
  std::vector<int> frames; ///< numbers of the capture's frames that there is a colour image of, increasing
};

/// What a novel camera sees.
struct NovelView {
  ColorImage color; ///< 3 channels sRGB
  DepthImage depth; ///< metres, exact, 0 = nothing; empty if there is none
  LabelImage mask;  ///< labels; empty if there is none
};

/// The truth beside a capture: cameras.json, novel/, gt/object_pose.txt, gt/object_mesh.obj.
class GroundTruth {
public:
  /// Nothing if the folder has neither cameras.json nor gt/object_pose.txt. `capture_camera_to_world` is the pose of
  /// the capture camera at frame 0 in the clip's world: the identity unless the capture brings poses. It carries the
  /// file's cameras into the clip's world. Throws Error(kCorruptInput), naming the file.
  static std::optional<GroundTruth> read(const std::filesystem::path& capture,
                                         const SE3& capture_camera_to_world = SE3::Identity());

  const std::vector<NovelCamera>& novel_cameras() const { return novel_cameras_; }
  /// Throws Error(kCorruptInput), naming the file. Thread-safe.
  NovelView novel_view(const NovelCamera& camera, int frame) const;

  /// Object to capture camera, by frame number; empty if not known.
  const std::map<int, SE3>& object_to_camera() const { return object_to_camera_; }
  /// Mean of the object mesh's vertices, in the object's frame; nothing without a mesh.
  const std::optional<Eigen::Vector3d>& object_centroid() const { return object_centroid_; }

private:
  void read_cameras(const SE3& capture_camera_to_world);
  void read_object_poses();
  void read_object_mesh();

  std::filesystem::path folder_;
  std::vector<NovelCamera> novel_cameras_;
  std::map<int, SE3> object_to_camera_;
  std::optional<Eigen::Vector3d> object_centroid_;
};

} // namespace kinora::evaluate
