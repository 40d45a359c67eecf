#include "stray_scanner/stray_reader.h"

#include <cmath>

#include "common/files.h"
#include "common/frame_pairs.h"
#include "core/error.h"
#include "core/image_codec.h"

namespace kinora::formats {
namespace fs = std::filesystem;

namespace {

constexpr double kMillimetre = 0.001;

[[noreturn]] void fail(const fs::path& path, const std::string& problem) {
  throw Error(ErrorCode::kCorruptInput, path.string() + ": " + problem);
}

/// All words as finite numbers, or nothing.
std::vector<double> numbers_of(std::string_view line) {
  std::vector<double> numbers;
  for (const std::string_view word : split_words(line)) {
    const std::optional<double> number = parse_number(word);
    if (!number || !std::isfinite(*number)) return {};
    numbers.push_back(*number);
  }
  return numbers;
}

/// timestamp, frame, x, y, z, qx, qy, qz, qw and more; the first versions of the app: from x to qw, without a header.
std::optional<StrayPose> pose_of(const std::vector<double>& numbers, std::size_t line) {
  constexpr std::size_t kOldWidth = 7;
  constexpr std::size_t kWidth = 9;
  constexpr double kMaxFrame = 1e9;
  StrayPose pose;
  pose.frame = line;
  const double* at = numbers.data();
  if (numbers.size() >= kWidth) {
    if (!(at[1] >= 0 && at[1] < kMaxFrame)) return std::nullopt;
    pose.time = at[0];
    pose.frame = static_cast<std::size_t>(at[1]);
    at += 2;
  } else if (numbers.size() != kOldWidth) {
    return std::nullopt;
  }
  const Eigen::Quaterniond q(at[6], at[3], at[4], at[5]);
  if (!(std::abs(q.norm() - 1) < 1e-2)) return std::nullopt;
  pose.camera_to_world.linear() = q.normalized().toRotationMatrix();
  pose.camera_to_world.translation() = Eigen::Vector3d(at[0], at[1], at[2]);
  return pose;
}

std::string six_digits(std::size_t number) {
  const std::string digits = std::to_string(number);
  return std::string(digits.size() < 6 ? 6 - digits.size() : 0, '0') + digits;
}

} // namespace

std::vector<StrayPose> read_odometry(const fs::path& path, std::vector<std::string>& warnings) {
  const std::string text = read_text(path);
  std::vector<StrayPose> poses;
  std::size_t bad = 0;
  for (const std::string_view line : split_lines(text)) {
    if (split_words(line).empty() || line.starts_with("timestamp")) continue;
    if (const auto pose = pose_of(numbers_of(line), poses.size() + bad))
      poses.push_back(*pose);
    else
      ++bad;
  }
  if (poses.empty()) fail(path, "holds no line \"timestamp, frame, x, y, z, qx, qy, qz, qw\"");
  if (bad > 0) warnings.push_back(path.string() + ": " + std::to_string(bad) + " lines hold no pose and are left out");
  const auto time_of = [](const StrayPose& pose) { return pose.time.value_or(static_cast<double>(pose.frame)); };
  const auto earlier = [&](const StrayPose& a, const StrayPose& b) { return time_of(a) < time_of(b); };
  if (std::is_sorted(poses.begin(), poses.end(), earlier)) return poses;
  warnings.push_back(path.string() + ": the times are out of order; frames are taken in order of time");
  std::stable_sort(poses.begin(), poses.end(), earlier);
  return poses;
}

Intrinsics read_camera_matrix(const fs::path& path) {
  const std::vector<double> k = numbers_of(read_text(path));
  if (k.size() != 9 || k[8] != 1 || k[3] != 0) fail(path, "is not a camera matrix fx, s, cx; 0, fy, cy; 0, 0, 1");
  return {0, 0, k[0], k[4], k[2], k[5]};
}

StrayReader::StrayReader(const fs::path& folder) : folder_(folder) {
  if (!fs::exists(folder / "odometry.csv") || !fs::exists(folder / "rgb.mp4"))
    throw Error(ErrorCode::kNotRecognised,
                folder.string() + ": not a folder of Stray Scanner; it needs rgb.mp4, odometry.csv and depth/");
  poses_ = read_odometry(folder / "odometry.csv", warnings_);
  VideoDescription video = describe_video(folder / "rgb.mp4");
  if (video.streams.empty()) fail(folder / "rgb.mp4", "holds no pictures");
  stream_ = std::move(video.streams.front());
  const std::size_t before = poses_.size();
  std::erase_if(poses_, [this](const StrayPose& pose) { return pose.frame >= stream_.times.size(); });
  if (poses_.empty()) fail(folder / "rgb.mp4", "holds none of the pictures that odometry.csv has poses for");
  if (poses_.size() < before)
    warnings_.push_back((folder / "rgb.mp4").string() + ": " + std::to_string(before - poses_.size()) +
                        " frames of odometry.csv are missing and left out");
  video_ = open_video(folder / "rgb.mp4", stream_);
  color_camera_ = read_camera_matrix(folder / "camera_matrix.csv");
  color_camera_.width = stream_.width;
  color_camera_.height = stream_.height;
  color_camera_.validate((folder / "camera_matrix.csv").string());
  std::string problem = (folder / "depth").string() + ": holds no depth image";
  for (const StrayPose& pose : poses_) {
    try {
      const fs::path path = image_file("depth", pose);
      const DepthImage16 depth = decode_depth16(read_file(path), path.string());
      check_shape(depth.width(), depth.height(), path);
      depth_camera_ = color_camera_.resized(depth.width(), depth.height());
      break;
    } catch (const Error& error) {
      problem = error.what();
    }
  }
  if (depth_camera_.width == 0)
    throw Error(ErrorCode::kCorruptInput, problem + "; no depth of this capture can be read");
  std::vector<double> times;
  times.reserve(poses_.size());
  for (const StrayPose& pose : poses_) times.push_back(time_of(pose));
  frames_per_second_ = median_rate(times);
  warning_table_.set(warnings_);
}

fs::path StrayReader::image_file(const char* kind, const StrayPose& pose) const {
  return folder_ / kind / (six_digits(pose.frame) + ".png");
}

void StrayReader::fill_info(KinoraCaptureInfo& info) const {
  info.frame_count = static_cast<std::int64_t>(poses_.size());
  info.start_time = time_of(poses_.front());
  info.frames_per_second = frames_per_second_;
  info.camera = camera_of(color_camera_, {});
  info.has_poses = 1;
  warning_table_.fill(info);
  set_depth_camera(info, camera_of(depth_camera_, {}), SE3::Identity());
}

/// Both lenses see the same; a video that was turned since does not.
void StrayReader::check_shape(int width, int height, const fs::path& path) const {
  constexpr double kTolerance = 0.05;
  const double wanted = static_cast<double>(stream_.width) / stream_.height;
  if (std::abs(static_cast<double>(width) / height / wanted - 1) < kTolerance) return;
  fail(path, "is " + std::to_string(width) + "x" + std::to_string(height) + ", and rgb.mp4 is shown as " +
                 std::to_string(stream_.width) + "x" + std::to_string(stream_.height) +
                 "; export the scan again, with a video that is not turned or cut");
}

void StrayReader::check_depth_size(int width, int height, const fs::path& path) const {
  if (width == depth_camera_.width && height == depth_camera_.height) return;
  fail(path, "is " + std::to_string(width) + "x" + std::to_string(height) + ", not " +
                 std::to_string(depth_camera_.width) + "x" + std::to_string(depth_camera_.height) + " as the others");
}

KinoraStatus StrayReader::next(KinoraFrame& frame) {
  if (next_ >= poses_.size()) return KINORA_END;
  frame.index = static_cast<std::int64_t>(next_);
  const StrayPose& pose = poses_[next_++];
  frame.time = time_of(pose);
  const fs::path depth_path = image_file("depth", pose);
  depth_ = decode_depth16(read_file(depth_path), depth_path.string());
  check_depth_size(depth_.width(), depth_.height(), depth_path);
  confidence_ = LabelImage();
  if (const fs::path path = image_file("confidence", pose); fs::exists(path)) {
    confidence_ = decode_labels(read_file(path), path.string());
    check_depth_size(confidence_.width(), confidence_.height(), path);
  }
  picture_ = video_->read(pose.frame);
  if (picture_.color.empty()) fail(folder_ / "rgb.mp4", "is no video in colour");
  set_pose(frame, pose.camera_to_world);
  frame.color = view_of(picture_.color, KINORA_PIXEL_U8);
  frame.depth = view_of(depth_, KINORA_PIXEL_U16);
  frame.depth_unit = kMillimetre;
  frame.confidence = view_of(confidence_, KINORA_PIXEL_U8);
  return KINORA_OK;
}

void StrayReader::seek(std::int64_t index) { next_ = checked_seek(index, poses_.size()); }

} // namespace kinora::formats
