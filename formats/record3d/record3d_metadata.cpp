#include <cmath>

#include <nlohmann/json.hpp>

#include "core/error.h"
#include "record3d/record3d_reader.h"

namespace kinora::formats {
namespace {

using Json = nlohmann::json;

constexpr double kMaxSide = 16384;

/// qx qy qz qw tx ty tz of ARKit, whose camera axes are x right, y up, z back.
SE3 pose_of(const std::array<double, 7>& given) {
  const Eigen::Quaterniond q(given[3], given[0], given[1], given[2]);
  if (!(std::abs(q.norm() - 1) < 1e-2)) throw std::invalid_argument("a pose is no unit quaternion");
  SE3 pose = SE3::Identity();
  pose.linear() = q.normalized().toRotationMatrix() * Eigen::Vector3d(1, -1, -1).asDiagonal();
  pose.translation() = Eigen::Vector3d(given[4], given[5], given[6]);
  if (!pose.matrix().allFinite()) throw std::invalid_argument("a pose is not finite");
  return pose;
}

int side_of(const Json& json, const char* name) {
  const auto side = json.at(name).get<double>();
  if (!(side >= 1 && side <= kMaxSide)) throw std::invalid_argument(std::string(name) + " is absurd");
  return static_cast<int>(side);
}

Record3dMetadata metadata_of(const Json& json, const std::string& source) {
  Record3dMetadata metadata;
  const auto k = json.at("K").get<std::array<double, 9>>(); // column by column
  metadata.color = {side_of(json, "w"), side_of(json, "h"), k[0], k[4], k[6], k[7]};
  metadata.color.validate(source);
  metadata.depth_width = json.contains("dw") ? side_of(json, "dw") : metadata.color.width;
  metadata.depth_height = json.contains("dh") ? side_of(json, "dh") : metadata.color.height;
  metadata.frames_per_second = json.value("fps", 60.0);
  if (!(metadata.frames_per_second > 0 && metadata.frames_per_second < 1e5))
    throw std::invalid_argument("fps is absurd");
  if (json.contains("frameTimestamps")) json["frameTimestamps"].get_to(metadata.times);
  if (json.contains("poses"))
    for (const Json& pose : json["poses"]) metadata.poses.push_back(pose_of(pose.get<std::array<double, 7>>()));
  for (const double time : metadata.times)
    if (!std::isfinite(time)) throw std::invalid_argument("a time is not finite");
  return metadata;
}

} // namespace

Record3dMetadata read_record3d_metadata(std::span<const std::byte> bytes, const std::string& source) {
  const auto* text = reinterpret_cast<const char*>(bytes.data());
  try {
    return metadata_of(Json::parse(text, text + bytes.size()), source);
  } catch (const Json::exception& error) {
    throw Error(ErrorCode::kCorruptInput, source + ": is no metadata of Record3D: " + error.what());
  } catch (const std::invalid_argument& error) {
    throw Error(ErrorCode::kCorruptInput, source + ": " + error.what());
  }
}

} // namespace kinora::formats
