#include "motion_capture.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

#include "core/error.h"
#include "text_file.h"

namespace kinora::simulator {

MotionCapture::MotionCapture(const std::filesystem::path& path) {
  const auto fail = [&path] {
    throw Error(ErrorCode::kCorruptInput, path.string() + ": not the motion of a skeleton in BVH");
  };
  std::istringstream words(read_text_file(path));
  std::vector<int> open{-1};
  std::string name;
  for (std::string word; words >> word && word != "MOTION";) {
    if (word == "ROOT" || word == "JOINT" || word == "End") {
      words >> name;
      if (word == "End") name.clear();
    } else if (word == "{") {
      if (!name.empty()) {
        index_[name] = joints_.size();
        joints_.push_back({open.back(), Eigen::Vector3d::Zero(), ""});
      }
      open.push_back(name.empty() ? open.back() : static_cast<int>(joints_.size()) - 1);
    } else if (word == "}") {
      open.pop_back();
    } else if (word == "OFFSET" && !name.empty()) {
      Joint& joint = joints_.back();
      for (double& x : joint.rest) words >> x;
      if (joint.parent >= 0) joint.rest += joints_[static_cast<std::size_t>(joint.parent)].rest;
    } else if (word == "CHANNELS" && !name.empty()) {
      int count = 0;
      words >> count;
      for (std::string channel; count > 0 && words >> channel; --count)
        if (channel.ends_with("rotation")) joints_.back().rotation_axes += channel.front();
    }
  }
  std::string label;
  std::size_t count = 0;
  words >> label >> count >> label >> label >> seconds_per_frame_;
  if (!words || joints_.empty() || count == 0 || !(seconds_per_frame_ > 0)) fail();
  const std::size_t width = 3 + 3 * joints_.size();
  for (std::size_t i = 0; i < count; ++i) {
    std::vector<double>& frame = frames_.emplace_back(width);
    for (double& value : frame) words >> value;
  }
  if (!words) fail();
}

Eigen::Quaterniond MotionCapture::local_rotation(std::size_t joint, double seconds) const {
  const auto at = [&](std::size_t frame) {
    Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
    for (std::size_t i = 0; i < 3; ++i) {
      const double angle = frames_[frame][3 + 3 * joint + i] * std::numbers::pi / 180;
      rotation = rotation * Eigen::AngleAxisd(angle, Eigen::Vector3d::Unit(joints_[joint].rotation_axes[i] - 'X'));
    }
    return rotation;
  };
  const double place = std::clamp(seconds / seconds_per_frame_, 0.0, static_cast<double>(frames_.size() - 1));
  const auto before = static_cast<std::size_t>(place);
  const std::size_t after = std::min(before + 1, frames_.size() - 1);
  return at(before).slerp(place - static_cast<double>(before), at(after));
}

Eigen::Quaterniond MotionCapture::rotation(const std::string& joint, double seconds) const {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  for (int i = static_cast<int>(index_.at(joint)); i >= 0; i = joints_[static_cast<std::size_t>(i)].parent)
    rotation = local_rotation(static_cast<std::size_t>(i), seconds) * rotation;
  return rotation;
}

Eigen::Vector3d MotionCapture::position(double seconds) const {
  const double place = std::clamp(seconds / seconds_per_frame_, 0.0, static_cast<double>(frames_.size() - 1));
  const auto before = static_cast<std::size_t>(place);
  const std::size_t after = std::min(before + 1, frames_.size() - 1);
  const Eigen::Map<const Eigen::Vector3d> a(frames_[before].data());
  const Eigen::Map<const Eigen::Vector3d> b(frames_[after].data());
  return a + (place - static_cast<double>(before)) * (b - a);
}

Eigen::Vector3d MotionCapture::rest_position(const std::string& joint) const { return joints_[index_.at(joint)].rest; }

} // namespace kinora::simulator
