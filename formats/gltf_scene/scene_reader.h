// An animated scene as a virtual RGB-D camera sees it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/capture_info.h"
#include "common/label_file.h"
#include "gltf_scene/rasterizer.h"
#include "gltf_scene/scene.h"

namespace kinora::formats {

struct VirtualCamera {
  int width = 640;
  int height = 480;
  double frames_per_second = 30;
  double field_of_view = 50; ///< degrees from top to bottom, of an automatic camera
  std::string name;          ///< of a camera of the file, or its number from 1; "auto": placed to see everything at all
                             ///< times; empty: the file's first, else auto
};

/// Depth is exact, in steps of kFloatDepthUnit. The world is the file's. Meshes whose node, skin or morph targets move
/// are labels 1, 2, …, at most 15; the others are background. Not thread-safe. Images of a frame stay valid until the
/// next call.
class SceneReader {
public:
  /// `animation`: its name, or its number from 1; empty: the first, if there is one. Throws Error: kCorruptInput,
  /// kUsage for a camera, an animation, a size or a rate that cannot be.
  SceneReader(const std::filesystem::path& path, const VirtualCamera& camera, const std::string& animation,
              bool give_masks);

  void fill_info(KinoraCaptureInfo& info) const;
  /// KINORA_OK or KINORA_END.
  KinoraStatus next(KinoraFrame& frame);
  /// Throws Error(kUsage) outside of 0 … frame count.
  void seek(std::int64_t index);

private:
  void choose_camera(const std::string& name);
  void place_camera(double vertical_angle);
  void give_labels();
  Camera camera_at(const ScenePose& pose) const;
  double time_of(std::size_t frame) const { return static_cast<double>(frame) / camera_.frames_per_second; }

  std::string path_;
  VirtualCamera camera_;
  bool give_masks_;
  std::vector<std::string> warnings_;
  WarningTable warning_table_;
  Scene scene_;
  const SceneAnimation* animation_ = nullptr; ///< of scene_
  std::size_t frame_count_ = 1;
  Intrinsics intrinsics_;
  int camera_node_ = -1; ///< −1: placed_ is where it stands
  bool camera_moves_ = false;
  SE3 placed_ = SE3::Identity();
  LabelTable labels_;
  std::vector<std::uint8_t> label_of_; ///< by thing
  std::size_t next_ = 0;
  ColorImage color_;
  DepthImage16 depth_;
  LabelImage mask_;
};

} // namespace kinora::formats
