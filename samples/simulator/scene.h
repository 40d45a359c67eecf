// The scenes of the samples: a person of free mesh and motion, what is about them, and the sensor that sees it.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "human.h"
#include "meshes.h"
#include "renderer.h"
#include "sensor.h"

namespace kinora::simulator {

/// A rigid thing and where it is: from its own axes to the world, at a time and with the person as they are then.
struct Thing {
  std::uint8_t label; ///< 0: of the room
  Mesh mesh;
  std::function<Eigen::Vector3d(const Eigen::Vector3d&)> colour; ///< of its own axes
  std::function<SE3(double seconds, const Human& human, const HumanPose& person)> pose;
  bool smooth = true;
};

/// What a person wears: reflectance at a point of the body at rest.
using Outfit = std::function<Eigen::Vector3d(Part, const Eigen::Vector3d&)>;

/// World: metres, y up, floor at y = 0, the person about the origin, facing z.
class Scene {
public:
  struct Parameters {
    std::string_view name;
    const char* motion;    ///< file of the motion
    double start;          ///< seconds into it
    double pace;           ///< seconds of the motion in one
    double facing_degrees; ///< how far the person is turned about y, from where the motion has them
    int frames;
    HumanOptions human;
    Outfit outfit;
    std::vector<Thing> things;
    Light light;
    SensorFaults sensor;
    Camera camera;
  };

  /// `data`: the folder with body_cc0 and mocap_cmu. Throws Error(kCorruptInput).
  Scene(const std::filesystem::path& data, Parameters parameters);

  const Parameters& parameters() const { return parameters_; }
  const Human& human() const { return human_; }
  HumanPose person_at(double seconds) const;
  /// The person's surface comes first, then the things'.
  std::vector<Surface> surfaces_at(double seconds) const;

private:
  Parameters parameters_;
  Human human_;
  MotionCapture motion_;
  SE3 motion_to_world_ = SE3::Identity();
};

constexpr double kFramesPerSecond = 30;

/// Of all samples, in their order.
std::vector<std::function<Scene(const std::filesystem::path& data)>> sample_scenes();

/// At `eye`, looking at `target`, upright. 320×240.
Camera camera_at(const Eigen::Vector3d& eye, const Eigen::Vector3d& target);

} // namespace kinora::simulator
