// Data sets for other programs, written and read again.
#include <gtest/gtest.h>

#include <cmath>

#include <nlohmann/json.hpp>

#include "core/error.h"
#include "formats/sample_capture.h"
#include "host/frame_reader.h"
#include "host/picture_writer.h"
#include "host/plugin_table.h"

namespace kinora::formats {
namespace {

using namespace kinora::test;
using host::Picture;

constexpr int kWidth = 16;
constexpr int kHeight = 12;

SE3 pose_of(int i) {
  SE3 pose = SE3::Identity();
  pose.rotate(Eigen::AngleAxisd(0.1 * i, Eigen::Vector3d(1, 2, 3).normalized()));
  pose.translation() = Eigen::Vector3d(0.1 * i, 0.2, -0.3);
  return pose;
}

class DataSetTest : public testing::Test {
protected:
  DataSetTest() {
    for (int i = 0; i < 3; ++i) {
      Picture& picture =
          pictures_.emplace_back(Picture{six_digits(i), 0.04 * i, sample_color(kWidth, kHeight, 3, i), {}});
      picture.metric_depth = DepthImage(kWidth, kHeight);
      for (std::size_t k = 0; k < picture.metric_depth.pixel_count(); ++k)
        picture.metric_depth.data()[k] = 0.5F + 0.0137F * static_cast<float>(k);
      picture.metric_depth.data()[0] = 0;
      picture.labels = LabelImage(kWidth, kHeight, 1, static_cast<std::uint8_t>(i));
      picture.label_meanings = meanings_;
      picture.camera = Camera{{kWidth, kHeight, 20, 21, 7.25, 5.5}, pose_of(i)};
    }
  }
  void write() const {
    host::PictureWriter writer(table_.find("data-set"), folder_.path() / "set", {});
    for (const Picture& picture : pictures_) writer.write(picture);
    writer.finish();
  }

  std::vector<host::LabelMeaning> meanings_{{0, "background", "still"}, {1, "anna", "deforming"}, {2, "box", "rigid"}};
  std::vector<Picture> pictures_;
  TemporaryFolder folder_;
  host::PluginTable table_ = host::PluginTable::builtin();
};

TEST_F(DataSetTest, ReadsBackAsTheCaptureThatItShows) {
  write();
  const KinoraFormat& format = table_.recognise(folder_.path() / "set");
  EXPECT_STREQ(format.name, "transforms");
  host::FrameReader reader(format, folder_.path() / "set", {});
  const KinoraCaptureInfo& info = reader.info();
  EXPECT_EQ(info.camera.fx, 20);
  EXPECT_EQ(info.camera.cx, 7.25);
  EXPECT_NEAR(info.frames_per_second, 25, 1e-9);
  ASSERT_EQ(info.label_count, 3U);
  EXPECT_STREQ(info.labels[1].name, "anna");
  EXPECT_STREQ(info.labels[2].kind, "rigid");
  for (int i = 0; i < 3; ++i) {
    const Picture& given = pictures_[static_cast<std::size_t>(i)];
    const auto read = reader.next();
    ASSERT_TRUE(read && read->problem.empty());
    const KinoraFrame& frame = read->frame;
    EXPECT_NEAR(frame.time, given.time, 1e-12);
    EXPECT_EQ(std::memcmp(frame.color.data, given.color.data(), 3 * kWidth * kHeight), 0);
    EXPECT_EQ(std::memcmp(frame.labels.data, given.labels.data(), kWidth * kHeight), 0);
    for (std::size_t k = 0; k < kWidth * kHeight; ++k)
      EXPECT_NEAR(static_cast<const std::uint16_t*>(frame.depth.data)[k] * frame.depth_unit,
                  given.metric_depth.data()[k], 0.00051);
    for (int k = 0; k < 16; ++k) EXPECT_NEAR(frame.camera_to_world[k], pose_of(i).matrix()(k / 4, k % 4), 1e-9);
  }
}

TEST_F(DataSetTest, CamerasThatDifferStandAtTheirFrames) {
  pictures_[1].camera->intrinsics.fx = 22;
  write();
  std::ifstream file(folder_.path() / "set/transforms.json");
  const auto json = nlohmann::json::parse(file);
  EXPECT_FALSE(json.contains("fl_x"));
  EXPECT_EQ(json["frames"][1]["fl_x"], 22);
  EXPECT_EQ(json["cx"], 7.75) << "the first pixel has its centre at 0.5";
  EXPECT_EQ(json["frames"][2]["file_path"], "images/000002.png");
}

TEST_F(DataSetTest, DepthBeyondSixteenBitsIsNoDepth) {
  pictures_[0].metric_depth.data()[5] = 70;
  write();
  std::ifstream file(folder_.path() / "set/depth/000000.png", std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(file)), {});
  EXPECT_EQ(decode_depth16(std::as_bytes(std::span(text)), "depth").data()[5], 0);
}

TEST_F(DataSetTest, PicturesWithoutDepthOrCameraAndNamesOutsideAreRefused) {
  host::PictureWriter writer(table_.find("data-set"), folder_.path() / "set", {});
  Picture picture = pictures_[0];
  picture.camera.reset();
  EXPECT_THROW(writer.write(picture), Error);
  picture = pictures_[0];
  picture.metric_depth = {};
  EXPECT_THROW(writer.write(picture), Error);
  picture = pictures_[0];
  picture.name = "../../escaped";
  EXPECT_THROW(writer.write(picture), Error);
  EXPECT_THROW(writer.finish(), Error) << "there is no picture";
}

} // namespace
} // namespace kinora::formats
