#include "scene.h"

#include <algorithm>
#include <limits>
#include <numbers>

namespace kinora::simulator {

using Vec = Eigen::Vector3d;

Camera camera_at(const Vec& eye, const Vec& target) {
  Camera camera;
  camera.intrinsics = {320, 240, 262.5, 262.5, 159.5, 119.5};
  const Vec forward = (target - eye).normalized();
  const Vec right = forward.cross(Vec::UnitY()).normalized();
  camera.camera_to_world.linear() << right, forward.cross(right), forward;
  camera.camera_to_world.translation() = eye;
  return camera;
}

Scene::Scene(const std::filesystem::path& data, Parameters parameters)
    : parameters_(std::move(parameters)), human_(data / "body_cc0", parameters_.human),
      motion_(data / "mocap_cmu" / parameters_.motion) {
  motion_to_world_.linear() =
      Eigen::AngleAxisd(parameters_.facing_degrees * std::numbers::pi / 180, Vec::UnitY()).toRotationMatrix();
  Vec middle = Vec::Zero();
  double lowest = std::numeric_limits<double>::max();
  for (int frame = 0; frame < parameters_.frames; ++frame) {
    const HumanPose pose = person_at(frame / kFramesPerSecond);
    middle += pose.joints[0] / parameters_.frames;
    for (const auto& face : human_.faces()) // what is not drawn does not stand on the floor
      for (const int vertex : face) lowest = std::min(lowest, pose.vertices[static_cast<std::size_t>(vertex)].y());
  }
  motion_to_world_.translation() = -Vec(middle.x(), lowest, middle.z());
}

HumanPose Scene::person_at(double seconds) const {
  HumanPose pose = human_.pose(motion_, parameters_.start + parameters_.pace * seconds);
  for (Vec& vertex : pose.vertices) vertex = motion_to_world_ * vertex;
  for (Vec& joint : pose.joints) joint = motion_to_world_ * joint;
  for (SE3& bone : pose.bones) bone = motion_to_world_ * bone;
  return pose;
}

std::vector<Surface> Scene::surfaces_at(double seconds) const {
  const HumanPose person = person_at(seconds);
  std::vector<Surface> surfaces;
  const auto person_colour = [this](const Vec& rest, std::size_t face) -> Vec {
    return parameters_.outfit(human_.parts()[face], rest);
  };
  surfaces.push_back({person.vertices, human_.rest(), human_.faces(), person_colour, 1, true});
  for (const Thing& thing : parameters_.things) {
    const SE3 pose = thing.pose(seconds, human_, person);
    std::vector<Vec> vertices;
    vertices.reserve(thing.mesh.vertices.size());
    for (const Vec& vertex : thing.mesh.vertices) vertices.emplace_back(pose * vertex);
    const auto colour = [&thing](const Vec& rest, std::size_t /*face*/) -> Vec { return thing.colour(rest); };
    surfaces.push_back({std::move(vertices), thing.mesh.vertices, thing.mesh.faces, colour, thing.label, thing.smooth});
  }
  return surfaces;
}

} // namespace kinora::simulator
