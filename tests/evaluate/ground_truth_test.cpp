#include "evaluate/ground_truth.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include "core/error.h"
#include "evaluate/ground_truth_tracks.h"
#include "formats/sample_capture.h"

namespace kinora::evaluate {
namespace {

using namespace kinora::test;

constexpr const char* kCameras = R"({"cameras": [
  {"name": "cam0", "width": 16, "height": 12, "fx": 20, "fy": 20, "cx": 7.5, "cy": 5.5,
   "camera_to_world": [[1, 0, 0, 5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]},
  {"name": "cam1", "width": 16, "height": 12, "fx": 20, "fy": 20, "cx": 7.5, "cy": 5.5,
   "camera_to_world": [[1, 0, 0, 7], [0, 1, 0, 0], [0, 0, 1, 1], [0, 0, 0, 1]]}]})";

template <class Call> void expect_corrupt(const std::string& word, const Call& call) {
  try {
    call();
    ADD_FAILURE() << "nothing was thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kCorruptInput);
    EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
  }
}

TEST(GroundTruth, IsAbsentWithoutItsFiles) {
  const TemporaryFolder folder;
  write_numbered(folder, 1);
  EXPECT_FALSE(GroundTruth::read(folder.path()));
}

TEST(GroundTruth, CamerasAreCarriedIntoTheClipsWorld) {
  const TemporaryFolder folder;
  folder.write("cameras.json", kCameras);
  const auto truth = GroundTruth::read(folder.path());
  ASSERT_EQ(truth->novel_cameras().size(), 1U);
  EXPECT_EQ(truth->novel_cameras()[0].name, "cam1");
  EXPECT_TRUE(truth->novel_cameras()[0].camera.camera_to_world.translation().isApprox(Eigen::Vector3d(2, 0, 1)));
  SE3 start = SE3::Identity();
  start.translation() = Eigen::Vector3d(0, 3, 0);
  const auto moved = GroundTruth::read(folder.path(), start);
  EXPECT_TRUE(moved->novel_cameras()[0].camera.camera_to_world.translation().isApprox(Eigen::Vector3d(2, 3, 1)));
}

TEST(GroundTruth, NovelViewsHaveColorDepthInMetresAndMask) {
  const TemporaryFolder folder;
  folder.write("cameras.json", kCameras);
  folder.write("novel/cam1/rgb/000010.jpg", jpeg_of(sample_color(16, 12)));
  folder.write("novel/cam1/rgb/000000.jpg", jpeg_of(sample_color(16, 12)));
  folder.write("novel/cam1/depth/000010.png", depth_bytes(0));
  folder.write("novel/cam1/mask/000010.png", encode_png(ColorImage(16, 12, 1, 2)));
  const auto truth = GroundTruth::read(folder.path());
  const NovelCamera& camera = truth->novel_cameras().at(0);
  EXPECT_EQ(camera.frames, (std::vector<int>{0, 10}));
  const NovelView view = truth->novel_view(camera, 10);
  EXPECT_EQ(view.color.width(), 16);
  EXPECT_FLOAT_EQ(view.depth.at(1, 0), 1.001F);
  EXPECT_EQ(view.mask.at(3, 3), 2);
  EXPECT_TRUE(truth->novel_view(camera, 0).depth.empty());
  expect_corrupt("frame 5", [&] { (void)truth->novel_view(camera, 5); });
  folder.write("novel/cam1/depth/000010.png", encode_png16(sample_depth(8, 6)));
  expect_corrupt("size", [&] { (void)truth->novel_view(camera, 10); });
}

TEST(GroundTruth, ObjectPosesAndCentroidAreRead) {
  const TemporaryFolder folder;
  folder.write("gt/object_pose.txt", "# frame time matrix\n0 1000.0 1 0 0 0.5 0 1 0 0 0 0 1 2 0 0 0 1\n"
                                     "4 1000.1 1 0 0 0.6 0 1 0 0 0 0 1 2 0 0 0 1\r\n");
  folder.write("gt/object_mesh.obj", "# box\nv 0 0 0\nv 1 2 3\nvt 9 9\nf 1 2 1\n");
  const auto truth = GroundTruth::read(folder.path());
  ASSERT_EQ(truth->object_to_camera().size(), 2U);
  EXPECT_NEAR(truth->object_to_camera().at(4).translation().x(), 0.6, 1e-12);
  EXPECT_TRUE(truth->object_centroid()->isApprox(Eigen::Vector3d(0.5, 1, 1.5)));
}

TEST(GroundTruth, DamageIsAnErrorThatNamesFileAndPlace) {
  const TemporaryFolder folder;
  folder.write("cameras.json", "{\"cameras\": [{}]}");
  expect_corrupt("cameras.json", [&] { (void)GroundTruth::read(folder.path()); });
  folder.remove("cameras.json");
  folder.write("gt/object_pose.txt", "0 1000.0 1 0 0 0.5 0 1 0 0 0 0 1 2 0 0 0 1\n1 1000.0 1 0 0\n");
  expect_corrupt("object_pose.txt, line 2", [&] { (void)GroundTruth::read(folder.path()); });
  folder.write("gt/object_pose.txt", "0 1000.0 1 0 0 nan 0 1 0 0 0 0 1 2 0 0 0 1\n");
  expect_corrupt("object_pose.txt, line 1", [&] { (void)GroundTruth::read(folder.path()); });
  folder.remove("gt/object_pose.txt");
  folder.write("cameras.json", kCameras);
  folder.write("gt/object_mesh.obj", "f 1 2 3\n");
  expect_corrupt("object_mesh.obj", [&] { (void)GroundTruth::read(folder.path()); });
}

void write_gzip(const fs::path& path, const std::string& line, int count) {
  fs::create_directories(path.parent_path());
  const gzFile file = gzopen(path.c_str(), "wb");
  gzputs(file, "frame,id,x_m,y_m,z_m,visible\n");
  for (int i = 0; i < count; ++i) gzwrite(file, line.data(), static_cast<unsigned>(line.size()));
  gzclose(file);
}

TEST(GroundTruthTracks, AreReadByIdAndFrame) {
  const TemporaryFolder folder;
  write_gzip(folder.path() / "gt" / "tracks.csv.gz", "4,7,0.5,1,2,1\n", 1);
  const GroundTruthTracks tracks = read_ground_truth_tracks(folder.path());
  ASSERT_EQ(tracks.size(), 1U);
  EXPECT_TRUE(tracks.at(7).at(4).point.isApprox(Eigen::Vector3d(0.5, 1, 2)));
  EXPECT_TRUE(tracks.at(7).at(4).visible);
}

TEST(GroundTruthTracks, FilesThatUnpackToFarMoreThanListsDoAreRefused) {
  const TemporaryFolder folder;
  write_gzip(folder.path() / "gt" / "tracks.csv.gz", "0,0,0,0,0,0\n", 1'500'000); // 18 MB in 20 kB
  expect_corrupt("unpacks to far more", [&] { (void)read_ground_truth_tracks(folder.path()); });
}

} // namespace
} // namespace kinora::evaluate
