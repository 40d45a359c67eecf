// Captures as folders of images, bit by bit: TUM RGB-D, numbered images, and data sets with transforms.json.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/label_file.h"
#include "core/se3.h"
#include "kinora/plugin.h"

namespace kinora::formats {

enum class FolderLayout { kTum, kNumbered, kTransforms };

/// Not thread-safe. Colour that was decoded from JPEG keeps that file, other colour is PNG; depth is 16-bit PNG.
class FolderWriter {
public:
  /// `folder` is there and empty. `still_camera`: transforms.json has one and the same pose where a capture has none.
  FolderWriter(std::filesystem::path folder, FolderLayout layout, bool still_camera);

  /// Throws Error(kUsage) if transforms.json would have no poses.
  void set_capture(const KinoraCaptureInfo& info);
  /// Empty, or why the frame is left out. Throws Error: kUnwritableOutput, kUsage.
  std::string write(const KinoraFrame& frame);
  /// Writes the lists. Throws Error: kUnwritableOutput, kFailure without a frame.
  void finish() const;

private:
  struct Written {
    double time;
    std::string color; ///< file in the folder
    std::string depth;
    std::optional<SE3> camera_to_world;
  };

  std::string misfit(const KinoraFrame& frame) const;
  void write_images(const KinoraFrame& frame, Written& written) const;
  void write_text(const char* name, const std::string& text) const;
  void write_tum_lists() const;
  void write_transforms() const;

  std::filesystem::path folder_;
  FolderLayout layout_;
  bool still_camera_;
  KinoraCamera camera_{};
  double frames_per_second_ = 30;
  double start_time_ = 0;
  bool has_poses_ = false;
  double depth_unit_ = 0.001; ///< of the first frame, and so of all
  LabelTable labels_;
  std::vector<Written> written_;
};

} // namespace kinora::formats
