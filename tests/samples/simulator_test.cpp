// A sensor's faults are those that it is told to have, and the samples are what the simulator makes.
#include <numeric>

#include <gtest/gtest.h>

#include "core/sensor_noise.h"
#include "formats/sample_capture.h"
#include "simulator/capture_folder.h"
#include "support/source_folder.h"

namespace kinora::simulator {
namespace {

using Vec = Eigen::Vector3d;

constexpr double kFocal = 262.5;
constexpr double kWall = 2.0;
constexpr double kBox = 1.2;
constexpr double kHalf = 0.2; ///< of the box's sides

Camera camera() {
  Camera made;
  made.intrinsics = {160, 120, kFocal, kFocal, 79.5, 59.5};
  return made; // at the origin, along z, y down
}

Surface surface(const Mesh& mesh, const Vec& at) {
  std::vector<Vec> vertices;
  for (const Vec& vertex : mesh.vertices) vertices.emplace_back(vertex + at);
  const auto grey = [](const Vec&, std::size_t) { return Vec(0.5, 0.5, 0.5); };
  return {vertices, mesh.vertices, mesh.faces, grey, 0, false};
}

std::vector<Surface> wall() { return {surface(plane({-3, -3, kWall}, {6, 0, 0}, {0, 6, 0}, 8), Vec::Zero())}; }

std::vector<Surface> box_before_wall() {
  std::vector<Surface> scene = wall();
  scene.push_back(surface(plane({-kHalf, -kHalf, kBox}, {2 * kHalf, 0, 0}, {0, 2 * kHalf, 0}, 4), Vec::Zero()));
  return scene;
}

SensorFaults none() {
  SensorFaults faults;
  faults.noise = faults.baseline = faults.lost_at_edges = faults.flying_at_edges = faults.holes = 0;
  faults.colour_noise = 0;
  return faults;
}

DepthImage16 measured(const std::vector<Surface>& scene, const SensorFaults& faults, std::uint64_t seed = 1) {
  Random random(seed);
  return measure_depth(scene, camera(), rasterize(scene, camera()).depth, faults, random);
}

int count_of(const DepthImage16& depth, int least, int most) {
  return static_cast<int>(
      std::count_if(depth.values().begin(), depth.values().end(), [&](int z) { return z >= least && z <= most; }));
}

TEST(Sensor, WithoutFaultsMeasuresTheTruth) {
  const DepthImage16 depth = measured(box_before_wall(), none());
  EXPECT_EQ(count_of(depth, 1200, 1200) + count_of(depth, 2000, 2000), 160 * 120);
  EXPECT_NEAR(count_of(depth, 1200, 1200), std::pow(2 * kHalf * kFocal / kBox, 2), 200);
}

TEST(Sensor, NoiseHasTheSpreadOfTheNoiseModel) {
  SensorFaults faults = none();
  faults.noise = 2;
  const DepthImage16 depth = measured(wall(), faults);
  double sum = 0;
  for (const std::uint16_t z : depth.values()) sum += std::pow(z / 1000.0 - kWall, 2);
  const double spread = std::sqrt(sum / static_cast<double>(depth.pixel_count()));
  EXPECT_NEAR(spread, 2 * kSensorNoise.sigma(kWall), 0.05 * spread);
}

TEST(Sensor, StructuredLightGivesDepthInSteps) {
  SensorFaults faults = none();
  faults.noise = 3;
  faults.baseline = 0.075;
  faults.disparity_step = 0.125;
  const DepthImage16 depth = measured(wall(), faults);
  std::set<std::uint16_t> values(depth.values().begin(), depth.values().end());
  values.erase(0);
  EXPECT_LT(values.size(), 20U); // without steps: some sixty millimetres
  for (const std::uint16_t z : values) {
    const double steps = kFocal * faults.baseline / (z / 1000.0) / faults.disparity_step;
    EXPECT_NEAR(steps, std::round(steps), 0.05);
  }
}

TEST(Sensor, WhatTheProjectorDoesNotLightHasNoDepth) {
  SensorFaults faults = none();
  faults.baseline = 0.075;
  const DepthImage16 depth = measured(box_before_wall(), faults);
  const int row = 60;
  const int left = static_cast<int>(std::lround(79.5 - kFocal * kHalf / kBox));
  const int width = static_cast<int>(std::lround(kFocal * faults.baseline * (1 / kBox - 1 / kWall)));
  int dark = 0;
  for (int u = 0; u < 80; ++u) dark += depth.at(u, row) == 0 ? 1 : 0;
  EXPECT_NEAR(dark, width, 2);
  EXPECT_EQ(depth.at(left - width / 2, row), 0);
  for (int u = 80; u < 160; ++u) EXPECT_NE(depth.at(u, row), 0) << u; // it stands to the right of the camera
}

TEST(Sensor, EdgesAreLostOrFly) {
  SensorFaults faults = none();
  faults.lost_at_edges = 0.5;
  faults.flying_at_edges = 0.25;
  const DepthImage16 depth = measured(box_before_wall(), faults);
  const double edge = 8 * 2 * kHalf * kFocal / kBox; // pixels on both sides of four sides
  EXPECT_NEAR(count_of(depth, 0, 0) / edge, 0.5, 0.06);
  EXPECT_NEAR(count_of(depth, 1201, 1999) / edge, 0.25, 0.05);
}

TEST(Sensor, SeesNothingBeyondItsRangeAndNothingInHoles) {
  SensorFaults faults = none();
  faults.range = 1.9;
  EXPECT_EQ(count_of(measured(box_before_wall(), faults), 1900, 65535), 0);
  faults = none();
  faults.holes = 3;
  const int lost = count_of(measured(wall(), faults), 0, 0);
  EXPECT_GT(lost, 10);
  EXPECT_LT(lost, 3 * 81);
}

TEST(Sensor, ExposureDriftsAndNoiseIsOfItsSize) {
  const Image<float> light(64, 64, 3, 0.2F);
  const auto mean = [](const ColorImage& color) {
    return std::accumulate(color.values().begin(), color.values().end(), 0.0) /
           static_cast<double>(color.values().size());
  };
  SensorFaults faults = none();
  faults.exposure_drift = 0.2;
  Random random(1);
  EXPECT_NEAR(mean(expose(light, 0, faults, random)), mean(expose(light)), 0.01);
  EXPECT_GT(mean(expose(light, 0.5, faults, random)), mean(expose(light)) + 5);
  EXPECT_LT(mean(expose(light, 1.5, faults, random)), mean(expose(light)) - 5);
  faults = none();
  faults.colour_noise = 4;
  const ColorImage noisy = expose(light, 0, faults, random);
  const double middle = mean(noisy);
  double sum = 0;
  for (const std::uint8_t value : noisy.values()) sum += std::pow(value - middle, 2);
  EXPECT_NEAR(std::sqrt(sum / static_cast<double>(noisy.values().size())), 4 * 0.7, 0.15);
}

TEST(Renderer, NearerSurfacesHideOthersAndThrowShadows) {
  const Camera seeing = camera_at({0, 1, 2.5}, {0, 1, 0});
  Light light;
  light.lamp = {-0.8, 1.4, 2};
  std::vector<Surface> scene = {surface(plane({-3, -2, -1}, {6, 0, 0}, {0, 6, 0}, 8), Vec::Zero())};
  const View bare = render(scene, light, seeing);
  scene.push_back(surface(plane({-kHalf, 1 - kHalf, 0}, {2 * kHalf, 0, 0}, {0, 2 * kHalf, 0}, 4), Vec::Zero()));
  scene[1].label = 2;
  const View view = render(scene, light, seeing);
  EXPECT_EQ(view.labels.at(160, 120), 2);
  EXPECT_NEAR(view.depth.at(160, 120), 2.5, 1e-4);
  EXPECT_EQ(view.labels.at(5, 120), 0);
  EXPECT_NEAR(view.light.at(5, 120, 0), bare.light.at(5, 120, 0), 1e-6);
  EXPECT_LT(view.light.at(197, 146, 0), 0.5F * bare.light.at(197, 146, 0)); // beside the box, away from the lamp
}

TEST(MotionCapture, TurnsJointsInTheOrderOfTheFile) {
  const test::TemporaryFolder folder;
  folder.write("a.bvh", "HIERARCHY\nROOT hip\n{\n OFFSET 0 0 0\n CHANNELS 6 Xposition Yposition Zposition Zrotation "
                        "Yrotation Xrotation\n JOINT knee\n {\n  OFFSET 0 -2 0\n  CHANNELS 3 Zrotation Xrotation "
                        "Yrotation\n  End Site\n  {\n   OFFSET 0 -1 0\n  }\n }\n}\nMOTION\nFrames: 2\nFrame Time: "
                        "0.5\n0 1 0 0 0 0 0 0 0\n0 3 0 90 0 0 0 90 0\n");
  const MotionCapture motion(folder.path() / "a.bvh");
  EXPECT_TRUE(motion.rest_position("knee").isApprox(Vec(0, -2, 0)));
  EXPECT_TRUE(motion.position(0.25).isApprox(Vec(0, 2, 0)));
  EXPECT_TRUE((motion.rotation("hip", 0.5) * Vec::UnitX()).isApprox(Vec::UnitY(), 1e-9));
  EXPECT_TRUE((motion.rotation("knee", 0.5) * Vec::UnitY()).isApprox(Vec::UnitZ(), 1e-9));
  EXPECT_NEAR(motion.rotation("hip", 0.25).angularDistance(motion.rotation("hip", 0)), 0.7854, 1e-4);
}

std::string contents_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(Samples, AreWhatTheSimulatorMakes) {
  const std::filesystem::path data = test::source_folder() / ".." / "shared" / "data";
  if (!std::filesystem::exists(data / "body_cc0")) GTEST_SKIP() << (data / "body_cc0").string() << " is not there";
  const test::TemporaryFolder folder;
  for (const auto& make : sample_scenes()) {
    const Scene scene = make(data);
    const std::string name(scene.parameters().name);
    write_capture(scene, folder.path() / name, 1);
    for (const char* file : {"rgb/000000.jpg", "depth/000000.png", "mask/000000.png", "novel/cam1_p20/rgb/000000.jpg",
                             "intrinsics.json", "cameras.json"})
      EXPECT_TRUE(contents_of(folder.path() / name / file) ==
                  contents_of(test::source_folder() / "samples" / name / file))
          << name << "/" << file;
  }
}

} // namespace
} // namespace kinora::simulator
