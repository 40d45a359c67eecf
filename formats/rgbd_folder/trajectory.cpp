#include "rgbd_folder/trajectory.h"

#include <algorithm>
#include <iterator>
#include <span>

#include "common/files.h"
#include "core/error.h"

namespace kinora::formats {
namespace {

constexpr double kMaxInterpolationGap = 0.1; ///< seconds
constexpr double kUnitTolerance = 0.05;      ///< of a quaternion's length: text has few digits
constexpr std::size_t kMatrixWords = 16;

/// Row by row.
SE3 pose_of(std::span<const std::string_view> words, const std::filesystem::path& path) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Zero();
  for (std::size_t i = 0; i < kMatrixWords; ++i) {
    const std::optional<double> value = parse_number(words[i]);
    if (!value)
      throw Error(ErrorCode::kCorruptInput, path.string() + ": \"" + std::string(words[i]) + "\" is not a number");
    matrix(static_cast<Eigen::Index>(i / 4), static_cast<Eigen::Index>(i % 4)) = *value;
  }
  return rigid_from_matrix(matrix, path.c_str());
}

} // namespace

Trajectory Trajectory::read(const std::filesystem::path& path, std::vector<std::string>& warnings) {
  Trajectory trajectory;
  std::size_t bad_lines = 0;
  const std::string text = read_text(path);
  for (const std::string_view line : split_lines(text)) {
    const std::vector<std::string_view> words = split_words(line);
    if (words.empty() || words.front().starts_with('#')) continue;
    double values[8] = {};
    bool good = words.size() >= 8;
    for (std::size_t i = 0; good && i < 8; ++i) {
      const std::optional<double> value = parse_number(words[i]);
      good = value && std::isfinite(*value);
      if (good) values[i] = *value;
    }
    const Eigen::Quaterniond rotation(values[7], values[4], values[5], values[6]);
    if (!good || std::abs(rotation.norm() - 1) > kUnitTolerance) {
      ++bad_lines;
      continue;
    }
    SE3 pose = SE3::Identity();
    pose.linear() = rotation.normalized().toRotationMatrix();
    pose.translation() = Eigen::Vector3d(values[1], values[2], values[3]);
    trajectory.poses_.push_back({values[0], pose});
  }
  if (bad_lines > 0)
    warnings.push_back(path.string() + ": " + std::to_string(bad_lines) +
                       " lines are no pose \"time tx ty tz qx qy qz qw\" and are left out");
  std::stable_sort(trajectory.poses_.begin(), trajectory.poses_.end(),
                   [](const Pose& a, const Pose& b) { return a.time < b.time; });
  return trajectory;
}

std::optional<SE3> Trajectory::at(double time, double tolerance) const {
  const auto after = std::lower_bound(poses_.begin(), poses_.end(), time,
                                      [](const Pose& pose, double wanted) { return pose.time < wanted; });
  const bool has_after = after != poses_.end();
  const bool has_before = after != poses_.begin();
  if (has_after && after->time == time) return after->camera_to_world;
  if (has_after && has_before) {
    const auto before = after - 1;
    const double gap = after->time - before->time;
    if (gap <= kMaxInterpolationGap)
      return interpolate(before->camera_to_world, after->camera_to_world, (time - before->time) / gap);
  }
  const double to_after = has_after ? after->time - time : tolerance + 1;
  const double to_before = has_before ? time - (after - 1)->time : tolerance + 1;
  if (std::min(to_after, to_before) > tolerance) return std::nullopt;
  return to_after < to_before ? after->camera_to_world : (after - 1)->camera_to_world;
}

SE3 read_pose_file(const std::filesystem::path& path) {
  const std::string text = read_text(path);
  const std::vector<std::string_view> words = split_words(text);
  if (words.size() != kMatrixWords)
    throw Error(ErrorCode::kCorruptInput, path.string() + ": must hold a 4x4 camera-to-world matrix");
  return pose_of(words, path);
}

std::vector<SE3> read_trajectory_log(const std::filesystem::path& path) {
  constexpr std::size_t kFrameWords = 3 + kMatrixWords;
  const std::string text = read_text(path);
  std::vector<std::string_view> words;
  for (const std::string_view line : split_lines(text))
    if (!line.starts_with('#')) std::ranges::copy(split_words(line), std::back_inserter(words));
  if (words.size() % kFrameWords != 0)
    throw Error(ErrorCode::kCorruptInput,
                path.string() + ": must hold three numbers and a 4x4 camera-to-world matrix for each frame");
  std::vector<SE3> poses;
  for (std::size_t i = 0; i < words.size(); i += kFrameWords)
    poses.push_back(pose_of(std::span(words).subspan(i + 3, kMatrixWords), path));
  return poses;
}

} // namespace kinora::formats
