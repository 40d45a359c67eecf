#include "gltf_scene/scene_reader.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>

#include "common/float_depth.h"
#include "core/error.h"
#include "gltf_scene/gltf_file.h"

namespace kinora::formats {
namespace {

constexpr int kMaxSide = 8192;
constexpr double kMaxFrames = 1e6;
constexpr std::size_t kMaxLabels = 15; // what a capture may have besides the background

[[noreturn]] void refuse(const std::string& problem) { throw Error(ErrorCode::kUsage, problem); }

/// The place in `list` of what is called so, or has that number from 1.
template <class List> std::size_t find_called(const List& list, const std::string& name, const char* option) {
  for (std::size_t i = 0; i < list.size(); ++i)
    if (list[i].name == name) return i;
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  if (error == std::errc() && end == name.data() + name.size() && number >= 1 && number <= list.size())
    return number - 1;
  std::string there;
  for (const auto& item : list) there += (there.empty() ? "" : ", ") + ("\"" + item.name + "\"");
  refuse(std::string(option) + "=" + name + ": the file has none of that name or number; it has " +
         (there.empty() ? "none" : there));
}

/// A camera of glTF looks along −z with y up.
SE3 camera_pose(const Eigen::Affine3d& node_to_world) {
  SE3 pose = SE3::Identity();
  Eigen::Matrix3d axes = node_to_world.linear();
  for (int c = 0; c < 3; ++c) axes.col(c).normalize();
  pose.linear() = axes * Eigen::Vector3d(1, -1, -1).asDiagonal();
  pose.translation() = node_to_world.translation();
  return pose;
}

} // namespace

SceneReader::SceneReader(const std::filesystem::path& path, const VirtualCamera& camera, const std::string& animation,
                         bool give_masks)
    : path_(path.string()), camera_(camera), give_masks_(give_masks), scene_(read_gltf(path, warnings_)) {
  if (camera.width < 1 || camera.height < 1 || camera.width > kMaxSide || camera.height > kMaxSide)
    refuse("width and height must lie between 1 and 8192");
  if (!(camera.frames_per_second > 0 && camera.frames_per_second <= 1000)) refuse("fps must lie between 0 and 1000");
  if (!(camera.field_of_view >= 1 && camera.field_of_view <= 170)) refuse("fov must lie between 1 and 170 degrees");
  if (!animation.empty())
    animation_ = &scene_.animations[find_called(scene_.animations, animation, "animation")];
  else if (!scene_.animations.empty())
    animation_ = scene_.animations.data();
  if (animation_ == nullptr) warnings_.push_back(path_ + ": has no animation; it gives one frame");
  const double frames =
      animation_ == nullptr ? 1 : std::floor(animation_->duration * camera.frames_per_second + 1e-6) + 1;
  if (frames > kMaxFrames) refuse("the animation has more than a million frames at this rate; lower fps");
  frame_count_ = static_cast<std::size_t>(frames);
  find_motion(scene_, animation_);
  give_labels();
  choose_camera(camera.name);
  warning_table_.set(warnings_);
}

void SceneReader::give_labels() {
  bool too_many = false;
  for (const SceneThing& thing : scene_.things) {
    const std::size_t used = label_of_.empty() ? 0 : *std::ranges::max_element(label_of_);
    const bool is_still = !thing.moves && !thing.deforms;
    label_of_.push_back(is_still ? std::uint8_t{0} : static_cast<std::uint8_t>(std::min(used + 1, kMaxLabels)));
    if (is_still) continue;
    if (used < kMaxLabels)
      labels_.add(label_of_.back(), thing.name, thing.deforms ? "deforming" : "rigid");
    else
      too_many = true;
  }
  if (too_many) warnings_.push_back(path_ + ": more than 15 meshes move; the last ones share a label");
}

void SceneReader::choose_camera(const std::string& name) {
  double angle = camera_.field_of_view * std::numbers::pi / 180;
  if (name != "auto" && (!name.empty() || !scene_.cameras.empty())) {
    const SceneCamera& chosen =
        name.empty() ? scene_.cameras.front() : scene_.cameras[find_called(scene_.cameras, name, "camera")];
    camera_node_ = chosen.node;
    angle = chosen.vertical_angle;
    if (!camera_pose(ScenePose(scene_, animation_, 0).node_to_world(camera_node_)).matrix().allFinite())
      throw Error(ErrorCode::kCorruptInput, path_ + ": the camera \"" + chosen.name + "\" has no direction");
    if (animation_ != nullptr) {
      for (int node = camera_node_; node >= 0; node = scene_.nodes[static_cast<std::size_t>(node)].parent)
        camera_moves_ = camera_moves_ || std::ranges::any_of(animation_->tracks, [node](const SceneTrack& track) {
                          return track.node == node && track.path != ScenePath::kWeights;
                        });
    }
  }
  const double focal = camera_.height / (2 * std::tan(angle / 2));
  intrinsics_ = {camera_.width, camera_.height, focal, focal, (camera_.width - 1) / 2.0, (camera_.height - 1) / 2.0};
  if (camera_node_ < 0) place_camera(angle);
}

/// Before what the scene fills at some of its times, a little above, so far away that all of it is in the picture.
void SceneReader::place_camera(double vertical_angle) {
  constexpr std::size_t kTimes = 16;
  constexpr double kMargin = 1.05;
  Eigen::AlignedBox3d box;
  for (std::size_t i = 0; i < std::min(kTimes, frame_count_); ++i) {
    const ScenePose pose(scene_, animation_, time_of(i * frame_count_ / std::min(kTimes, frame_count_)));
    for (const SceneThing& thing : scene_.things)
      for (const ScenePrimitive& primitive : scene_.meshes[static_cast<std::size_t>(thing.mesh)])
        for (const Eigen::Vector3f& point : pose.vertices(thing, primitive)) box.extend(point.cast<double>());
  }
  const double radius = 0.5 * box.diagonal().norm();
  if (!std::isfinite(radius) || !(radius > 0)) throw Error(ErrorCode::kCorruptInput, path_ + ": fills no space");
  const double narrow = std::atan(std::tan(vertical_angle / 2) * std::min(1.0, 1.0 * camera_.width / camera_.height));
  const Eigen::Vector3d back = Eigen::Vector3d(0, 0.25, 1).normalized();
  const Eigen::Vector3d right = Eigen::Vector3d::UnitX();
  placed_.linear() << right, back.cross(right) * -1, -back;
  placed_.translation() = box.center() + back * (kMargin * radius / std::sin(narrow));
  if (kMargin * radius / std::sin(narrow) + radius > 65535 * kFloatDepthUnit)
    warnings_.push_back(path_ + ": reaches further than 16 m from the camera, beyond which nothing is measured; is it "
                                "in metres?");
}

Camera SceneReader::camera_at(const ScenePose& pose) const {
  return {intrinsics_, camera_node_ < 0 ? placed_ : camera_pose(pose.node_to_world(camera_node_))};
}

void SceneReader::fill_info(KinoraCaptureInfo& info) const {
  info.frame_count = static_cast<std::int64_t>(frame_count_);
  info.start_time = 0;
  info.frames_per_second = camera_.frames_per_second;
  info.camera = camera_of(intrinsics_, {});
  info.has_poses = camera_moves_ ? 1 : 0;
  info.has_masks = give_masks_ && !labels_.empty() ? 1 : 0;
  if (give_masks_) labels_.fill(info);
  warning_table_.fill(info);
}

KinoraStatus SceneReader::next(KinoraFrame& frame) {
  if (next_ >= frame_count_) return KINORA_END;
  const std::size_t index = next_++;
  const ScenePose pose(scene_, animation_, time_of(index));
  const Camera camera = camera_at(pose);
  Rasterizer rasterizer(camera);
  for (std::size_t i = 0; i < scene_.things.size(); ++i) {
    const SceneThing& thing = scene_.things[i];
    for (const ScenePrimitive& primitive : scene_.meshes[static_cast<std::size_t>(thing.mesh)])
      rasterizer.draw(primitive, pose.vertices(thing, primitive), scene_.images, label_of_[i]);
  }
  color_ = rasterizer.color();
  mask_ = rasterizer.labels();
  depth_ = DepthImage16(color_.width(), color_.height());
  for (std::size_t i = 0; i < depth_.pixel_count(); ++i)
    depth_.data()[i] = depth_units(static_cast<double>(rasterizer.depth().data()[i]));
  frame.index = static_cast<std::int64_t>(index);
  frame.time = time_of(index);
  frame.color = view_of(color_, KINORA_PIXEL_U8);
  frame.depth = view_of(depth_, KINORA_PIXEL_U16);
  frame.depth_unit = kFloatDepthUnit;
  if (give_masks_ && !labels_.empty()) frame.labels = view_of(mask_, KINORA_PIXEL_U8);
  if (camera_moves_) set_pose(frame, camera.camera_to_world);
  return KINORA_OK;
}

void SceneReader::seek(std::int64_t index) { next_ = checked_seek(index, frame_count_); }

} // namespace kinora::formats
