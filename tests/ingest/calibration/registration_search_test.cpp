#include "ingest/calibration/registration_search.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/parallel.h"
#include "core/random.h"
#include "core/sensor_noise.h"
#include "ingest/depth/registration_json.h"

namespace kinora::ingest {
namespace {

/// A camera that looks around in the corner of a papered room. It says that colour and depth are one camera's.
struct Scan {
  Intrinsics depth{160, 120, 140, 140, 79.5, 59.5};
  Intrinsics color = depth;
  bool exposure_changes = false;
  bool moves = true;
  bool poses_are_right = true;
  bool brings_poses = true;

  SE3 camera_to_world(int i) const {
    const double t = moves ? 0.4 * i : 0;
    const Eigen::Vector3d rotation(0.15 * std::sin(0.7 * t), 0.3 * std::sin(t), 0.3 * std::sin(1.3 * t));
    const Eigen::Vector3d position(0.2 * std::cos(t) - 0.2, 0.1 * std::sin(0.9 * t), 0.15 * std::sin(1.7 * t));
    return exp_se3((Twist() << position, rotation).finished());
  }
};

double corner_depth(const Eigen::Vector3d& origin, const Eigen::Vector3d& ray) {
  double z = (2.2 - origin.z()) / ray.z();
  if (ray.y() > 0) z = std::min(z, (0.6 - origin.y()) / ray.y());
  if (ray.x() > 0) z = std::min(z, (0.9 - origin.x()) / ray.x());
  return z;
}

double paper(const Eigen::Vector3d& p) {
  return std::sin(9 * p.x() + 2 * p.z()) + std::sin(11 * p.y() - 3 * p.z() + 1) + std::sin(5 * (p.x() + p.y())) +
         0.5 * std::sin(31 * p.x() - 17 * p.y() + 23 * p.z());
}

class ScanCapture final : public Capture {
public:
  explicit ScanCapture(const Scan& scan) : scan_(scan) {
    info_.intrinsics = scan.depth;
    info_.frame_count = kFrames;
    info_.has_poses = scan.brings_poses;
  }
  const CaptureInfo& info() const override { return info_; }
  const std::vector<SkippedFrame>& skipped() const override { return skipped_; }

  std::optional<Frame> next() override {
    if (next_ == kFrames) return std::nullopt;
    const int i = next_++;
    const SE3 pose = scan_.camera_to_world(i);
    const Intrinsics& k = scan_.depth;
    Frame frame;
    frame.index = i;
    frame.camera = {k, scan_.poses_are_right ? pose : scan_.camera_to_world(i * 7 % kFrames)};
    frame.color = ColorImage(k.width, k.height, 3);
    frame.depth = DepthImage(k.width, k.height);
    const double gain = scan_.exposure_changes ? 1 + 0.2 * std::sin(2.1 * i) : 1;
    Random random(3, static_cast<std::uint64_t>(i));
    for (int v = 0; v < k.height; ++v) {
      for (int u = 0; u < k.width; ++u) {
        const double z = corner_depth(pose.translation(), pose.linear() * k.unproject(u, v, 1));
        frame.depth.at(u, v) = static_cast<float>(z + kSensorNoise.sigma(z) * random.normal());
        const Eigen::Vector3d ray = pose.linear() * scan_.color.unproject(u, v, 1);
        const double light = 110 + 25 * paper(pose.translation() + corner_depth(pose.translation(), ray) * ray);
        for (int c = 0; c < 3; ++c) {
          frame.color.at(u, v, c) = static_cast<std::uint8_t>(std::clamp(gain * light + random.normal(), 0.0, 255.0));
        }
      }
    }
    frame.clean_depth = frame.depth;
    return frame;
  }

private:
  static constexpr int kFrames = 14;
  Scan scan_;
  CaptureInfo info_;
  std::vector<SkippedFrame> skipped_;
  int next_ = 0;
};

FoundRegistration search(const Scan& scan) {
  ScanCapture capture(scan);
  Progress progress;
  return search_registration(capture, progress);
}

TEST(RegistrationSearch, FindsAnotherFocalLength) {
  Scan scan;
  scan.color.fx = scan.color.fy = 0.88 * scan.depth.fx;
  const FoundRegistration found = search(scan);
  ASSERT_TRUE(found.geometry);
  EXPECT_NEAR(found.geometry->color.fx, scan.color.fx, 0.01 * scan.color.fx);
  EXPECT_EQ(found.geometry->depth, scan.depth);
  EXPECT_LT(found.unexplained, 0.5 * found.unexplained_as_given);
}

TEST(RegistrationSearch, FindsAShiftOfTwoPixels) {
  Scan scan;
  scan.color.cx += 2.3;
  scan.color.cy -= 1.4;
  const FoundRegistration found = search(scan);
  ASSERT_TRUE(found.geometry);
  EXPECT_NEAR(found.geometry->color.cx, scan.color.cx, 0.3);
  EXPECT_NEAR(found.geometry->color.cy, scan.color.cy, 0.3);
  EXPECT_NEAR(found.geometry->color.fx, scan.color.fx, 0.01 * scan.color.fx);
}

TEST(RegistrationSearch, LeavesRegisteredFramesAlone) {
  const FoundRegistration found = search({});
  EXPECT_GT(found.pairs, 10U);
  EXPECT_FALSE(found.geometry);
}

TEST(RegistrationSearch, DoesNotMindExposure) {
  Scan scan;
  scan.exposure_changes = true;
  EXPECT_FALSE(search(scan).geometry);
  scan.color.fx = scan.color.fy = 1.1 * scan.depth.fx;
  const FoundRegistration found = search(scan);
  ASSERT_TRUE(found.geometry);
  EXPECT_NEAR(found.geometry->color.fx, scan.color.fx, 0.01 * scan.color.fx);
}

TEST(RegistrationSearch, BlamesNoCameraForWrongPoses) {
  Scan scan;
  scan.poses_are_right = false;
  EXPECT_FALSE(search(scan).geometry);
}

TEST(RegistrationSearch, TellsNothingOfACameraThatStandsStillOrBringsNoPoses) {
  Scan still;
  still.moves = false;
  EXPECT_EQ(search(still).pairs, 0U);
  Scan unposed;
  unposed.brings_poses = false;
  EXPECT_EQ(search(unposed).pairs, 0U);
}

TEST(RegistrationSearch, HasTheSameBitsForAnyNumberOfThreads) {
  Scan scan;
  scan.color.fx = scan.color.fy = 0.9 * scan.depth.fx;
  set_thread_count(1);
  const FoundRegistration one = search(scan);
  set_thread_count(3);
  const FoundRegistration three = search(scan);
  set_thread_count(0);
  ASSERT_TRUE(one.geometry && three.geometry);
  EXPECT_EQ(one.geometry->color, three.geometry->color);
  EXPECT_EQ(one.unexplained, three.unexplained);
}

TEST(RegistrationJson, BringsBackTheSameCameras) {
  const RegistrationGeometry geometry{{160, 120, 140, 141, 79.5, 59.5},
                                      {160, 120, 120, 121, 81, 58},
                                      exp_se3((Twist() << 0.02, 0, 0.01, 0.1, 0.2, -0.1).finished())};
  const RegistrationGeometry back = registration_from_json(to_json(geometry), "a clip");
  EXPECT_EQ(back.depth, geometry.depth);
  EXPECT_EQ(back.color, geometry.color);
  EXPECT_TRUE(back.depth_to_color.isApprox(geometry.depth_to_color, 1e-12));
}

TEST(RegistrationJson, RefusesWhatIsNoCamera) {
  nlohmann::json json = to_json(RegistrationGeometry{{160, 120, 140, 141, 79.5, 59.5}, {160, 120, 1, 1, 1, 1}, {}});
  EXPECT_THROW(registration_from_json(nlohmann::json("no"), "a clip"), Error);
  nlohmann::json flat = json;
  flat["color"]["fx"] = 0;
  EXPECT_THROW(registration_from_json(flat, "a clip"), Error);
  json["depth_to_color"].erase(0);
  EXPECT_THROW(registration_from_json(json, "a clip"), Error);
}

} // namespace
} // namespace kinora::ingest
