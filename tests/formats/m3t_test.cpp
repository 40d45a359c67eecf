// Sequences of two cameras that are not registered: found by content, and clear about what is wrong with them.
#include <gtest/gtest.h>

#include "core/error.h"
#include "formats/sample_capture.h"
#include "rgbd_folder/folder_reader.h"
#include "rgbd_folder/listing.h"

namespace kinora::formats {
namespace {

using namespace kinora::test;

std::string camera_yaml(const std::string& pre, int width, int height, const std::string& pose, int first,
                        const std::string& more) {
  return "%YAML:1.2\nload_directory: \"./\"\nintrinsics:\n  f_u: 20\n  f_v: 21.5\n  pp_x: 7.5\n  pp_y: 5.5\n  width: " +
         std::to_string(width) + "\n  height: " + std::to_string(height) +
         "\ncamera2world_pose: !!opencv-matrix\n  rows: 4\n  cols: 4\n  dt: d\n  data: [" + pose + "]\n" + more +
         "image_name_pre: \"" + pre + "\"\nload_index: " + std::to_string(first) +
         "\nn_leading_zeros: 0\nimage_name_post: \"\"\nload_image_type: \"png\"\n";
}

constexpr const char* kIdentity = "1., 0, 0, 0,\n 0, 1., 0, 0,\n 0, 0, 1., 0,\n 0, 0, 0, 1.";
constexpr const char* kFiveCentimetres = "1, 0, 0, 0.05, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1";

void write_m3t(const TemporaryFolder& folder, const std::string& inside = "") {
  folder.write(inside + "color.yaml", camera_yaml("c_", kSampleWidth, kSampleHeight, kIdentity, 9, ""));
  folder.write(inside + "depth.yaml", camera_yaml("d_", 10, 8, kFiveCentimetres, 199, "depth_scale: 0.0005\n"));
  for (int i = 0; i < 3; ++i) {
    folder.write(inside + "c_" + std::to_string(9 + i) + ".png", color_bytes(i));
    folder.write(inside + "d_" + std::to_string(199 + i) + ".png", encode_png16(sample_depth(10, 8, 1500)));
  }
}

KinoraProbe probe(const fs::path& path) {
  KinoraProbe answer{};
  probe_m3t(path.c_str(), &answer);
  return answer;
}

TEST(M3t, IsFoundByItsContentAlsoOneFolderDown) {
  const TemporaryFolder folder, parent, other;
  write_m3t(folder);
  write_m3t(parent, "any name/");
  write_numbered(other, 2);
  EXPECT_EQ(probe(folder.path()).confidence, 90);
  EXPECT_EQ(probe(parent.path()).confidence, 90);
  EXPECT_EQ(probe(other.path()).confidence, 0);
  folder.remove("depth.yaml");
  EXPECT_EQ(probe(folder.path()).confidence, 0);
}

TEST(M3t, DeliversBothCamerasAndHowTheyStand) {
  const TemporaryFolder folder;
  write_m3t(folder);
  FolderReader reader(list_m3t(folder.path()), folder.path(), true);
  KinoraCaptureInfo info{};
  info.struct_size = sizeof info;
  reader.fill_info(info);
  EXPECT_EQ(info.frame_count, 3);
  EXPECT_EQ(info.camera.width, kSampleWidth);
  EXPECT_EQ(info.camera.fy, 21.5);
  ASSERT_EQ(info.has_depth_camera, 1);
  EXPECT_EQ(info.depth_camera.width, 10);
  EXPECT_NEAR(info.depth_to_color[3], 0.05, 1e-12);
  KinoraFrame frame{};
  ASSERT_EQ(reader.next(frame), KINORA_OK);
  EXPECT_EQ(frame.depth.width, 10);
  EXPECT_EQ(frame.color.width, kSampleWidth);
  EXPECT_EQ(frame.depth_unit, 0.0005);
}

TEST(M3t, PairsImagesByTheirPlaceAfterTheFirst) {
  const TemporaryFolder folder;
  write_m3t(folder);
  folder.remove("d_200.png");
  const Listing listing = list_m3t(folder.path());
  ASSERT_EQ(listing.frames.size(), 3U);
  EXPECT_TRUE(listing.frames[0].problem.empty());
  EXPECT_NE(listing.frames[1].problem.find("c_10.png"), std::string::npos);
  EXPECT_EQ(listing.frames[2].depth.filename(), "d_201.png");
}

void expect_refused(const std::string& from, const std::string& to, const std::string& word) {
  const TemporaryFolder folder;
  write_m3t(folder);
  std::string yaml = camera_yaml("d_", 10, 8, kFiveCentimetres, 199, "depth_scale: 0.0005\n");
  const std::size_t at = yaml.find(from);
  ASSERT_NE(at, std::string::npos) << from;
  folder.write("depth.yaml", yaml.replace(at, from.size(), to));
  try {
    list_m3t(folder.path());
    ADD_FAILURE() << "accepted with " << to;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kCorruptInput);
    EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("depth.yaml"), std::string::npos) << error.what();
  }
}

TEST(M3t, SaysWhichNumberOfACalibrationIsWrong) {
  expect_refused("width: 10", "width: -3", "intrinsics/width");
  expect_refused("f_v: 21.5", "f_v: nan", "intrinsics/f_v");
  expect_refused("  pp_x: 7.5\n", "", "intrinsics/pp_x");
  expect_refused("depth_scale: 0.0005", "depth_scale: 0", "depth_scale");
  expect_refused("0.05, 0, 1", "0.05, 0", "16 numbers");
  expect_refused("[1, 0", "[2, 0", "camera2world_pose");
  expect_refused("image_name_pre: \"d_\"", "image_name_pre: \"e_\"", "has no images");
  expect_refused("load_index: ", "load_index: 1e20\nother: ", "load_index");
}

TEST(M3t, SkipsAFrameWhoseDepthHasAnotherSize) {
  const TemporaryFolder folder;
  write_m3t(folder);
  folder.write("d_199.png", encode_png16(sample_depth(11, 8, 1500)));
  FolderReader reader(list_m3t(folder.path()), folder.path(), true);
  KinoraFrame frame{};
  EXPECT_THROW(reader.next(frame), Error);
  EXPECT_EQ(reader.next(frame), KINORA_OK);
}

} // namespace
} // namespace kinora::formats
