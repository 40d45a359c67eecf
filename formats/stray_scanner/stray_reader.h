// Folders of the app Stray Scanner: an iPhone's video with LiDAR depth, its confidence, and camera poses.
// Source: https://github.com/strayrobots/scanner, docs/format.md
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/capture_info.h"
#include "common/video_file.h"

namespace kinora::formats {

/// A line of odometry.csv.
struct StrayPose {
  std::optional<double> time; ///< seconds; the app's first versions wrote none
  std::size_t frame = 0;      ///< number of the video's picture, and in the names of depth/ and confidence/
  SE3 camera_to_world = SE3::Identity();
};

/// Lines that cannot be used are left out with a warning. Throws Error(kCorruptInput) if none can, or it cannot be
/// read.
std::vector<StrayPose> read_odometry(const std::filesystem::path& path, std::vector<std::string>& warnings);

/// fx, fy, cx, cy out of a 3×3 matrix with commas. Throws Error(kCorruptInput).
Intrinsics read_camera_matrix(const std::filesystem::path& path);

/// Not thread-safe. Images of a frame stay valid until the next call.
class StrayReader {
public:
  /// Throws Error: kNotRecognised, kCorruptInput, kMissingComponent.
  explicit StrayReader(const std::filesystem::path& folder);

  void fill_info(KinoraCaptureInfo& info) const;
  /// KINORA_OK or KINORA_END. Throws Error(kCorruptInput) for a bad frame, after which the next one can be read.
  KinoraStatus next(KinoraFrame& frame);
  /// Throws Error(kUsage) outside of 0 … frame count.
  void seek(std::int64_t index);

private:
  double time_of(const StrayPose& pose) const { return pose.time.value_or(stream_.times[pose.frame]); }
  std::filesystem::path image_file(const char* kind, const StrayPose& pose) const;
  void check_shape(int width, int height, const std::filesystem::path& path) const;
  void check_depth_size(int width, int height, const std::filesystem::path& path) const;

  std::filesystem::path folder_;
  std::vector<StrayPose> poses_;
  std::vector<std::string> warnings_;
  WarningTable warning_table_;
  VideoStream stream_;
  std::unique_ptr<VideoReader> video_;
  Intrinsics color_camera_;
  Intrinsics depth_camera_; ///< sees what the colour camera sees, in fewer pixels
  double frames_per_second_ = 60;
  std::size_t next_ = 0;
  VideoPicture picture_;
  DepthImage16 depth_;
  LabelImage confidence_;
};

} // namespace kinora::formats
