#include "player/camera_file.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "clip/sample_clip.h"
#include "core/error.h"
#include "formats/sample_capture.h"

namespace kinora::player {
namespace {

using Json = nlohmann::json;
using test::TemporaryFolder;

class Warnings : public Progress {
public:
  void warn(const std::string& sentence) override { sentences.push_back(sentence); }
  std::vector<std::string> sentences;
};

Json one_frame() {
  return {{"w", 640},
          {"h", 480},
          {"fl_x", 500.0},
          {"fl_y", 510.0},
          {"cx", 320.0},
          {"cy", 241.0},
          {"frames",
           {{{"file_path", "left"},
             {"time", 0.0},
             {"transform_matrix", {{1, 0, 0, 0.5}, {0, 1, 0, 0.25}, {0, 0, 1, -2}, {0, 0, 0, 1}}}}}}};
}

class CameraFile : public testing::Test {
protected:
  std::vector<View> read(const Json& json) { return read_text(json.dump()); }
  std::vector<View> read_text(const std::string& text) {
    folder_.write("transforms.json", text);
    return read_camera_file(folder_.path() / "transforms.json", clip_, warnings_);
  }
  // The error must name the file and hold `word`.
  void expect_rejected(const Json& json, const std::string& word) {
    try {
      read(json);
      FAIL() << "accepted: " << json;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kCorruptInput);
      EXPECT_NE(std::string(error.what()).find("transforms.json"), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
    }
  }

  TemporaryFolder folder_;
  clip::Clip clip_ = clip::testing::sample_clip(2, 6, false);
  Warnings warnings_;
};

TEST_F(CameraFile, PixelCentresMoveByHalfAPixel) {
  const View view = read(one_frame()).at(0);
  EXPECT_EQ(view.camera.intrinsics, (Intrinsics{640, 480, 500, 510, 319.5, 240.5}));
  EXPECT_EQ(view.name, "left");
}

TEST_F(CameraFile, CameraThatLooksBackAlongZBecomesOneThatLooksForward) {
  const SE3 pose = read(one_frame()).at(0).camera.camera_to_world;
  EXPECT_TRUE(pose.translation().isApprox(Eigen::Vector3d(0.5, 0.25, -2)));
  EXPECT_TRUE(pose.linear().col(0).isApprox(Eigen::Vector3d(1, 0, 0)));
  EXPECT_TRUE(pose.linear().col(1).isApprox(Eigen::Vector3d(0, -1, 0)));
  EXPECT_TRUE(pose.linear().col(2).isApprox(Eigen::Vector3d(0, 0, -1)));
}

TEST_F(CameraFile, FramesOverrideTheTopLevel) {
  Json json = one_frame();
  json["frames"][0]["fl_x"] = 700;
  json["frames"][0]["cx"] = 100.5;
  const Intrinsics camera = read(json).at(0).camera.intrinsics;
  EXPECT_EQ(camera.fx, 700);
  EXPECT_EQ(camera.fy, 510);
  EXPECT_EQ(camera.cx, 100);
}

TEST_F(CameraFile, AngleOfViewStandsForTheFocalLength) {
  Json json = one_frame();
  json.erase("fl_x");
  json.erase("fl_y");
  json["camera_angle_x"] = 2 * std::atan(0.5);
  const Intrinsics camera = read(json).at(0).camera.intrinsics;
  EXPECT_NEAR(camera.fx, 640, 1e-9);
  EXPECT_NEAR(camera.fy, 640, 1e-9);
}

TEST_F(CameraFile, TimeCountsFromTheStartAndFrameCountsFrames) {
  Json json = one_frame();
  json["frames"][0].erase("time");
  EXPECT_EQ(read(json).at(0).frame, 0);
  json["frames"][0]["frame"] = 2.5;
  EXPECT_EQ(read(json).at(0).frame, 2.5);
  json["frames"][0]["frame"] = 99;
  EXPECT_EQ(read(json).at(0).frame, 5);
  json["frames"][0]["time"] = clip_.times[3];
  EXPECT_NEAR(read(json).at(0).frame, 3, 1e-9);
}

TEST_F(CameraFile, NamesKeepFoldersAndLoseOneSuffix) {
  Json json = one_frame();
  json["frames"][0]["file_path"] = "./cam1/000010.png";
  EXPECT_EQ(read(json).at(0).name, "cam1/000010");
  json["frames"][0].erase("file_path");
  EXPECT_EQ(read(json).at(0).name, "000000");
}

TEST_F(CameraFile, RefusesNamesOutsideTheOutputFolder) {
  for (const char* name : {"../up", "/etc/passwd", "a/../../b", "", ".", "folder/"}) {
    Json json = one_frame();
    json["frames"][0]["file_path"] = name;
    expect_rejected(json, "file_path");
  }
}

TEST_F(CameraFile, RefusesWhatIsNoCamera) {
  Json json = one_frame();
  json.erase("w");
  expect_rejected(json, "\"w\" is missing");
  json = one_frame();
  json["h"] = "many";
  expect_rejected(json, "not a number");
  json = one_frame();
  json["w"] = 1e9;
  expect_rejected(json, "16384");
  json = one_frame();
  json["fl_x"] = 0;
  expect_rejected(json, "focal");
  json = one_frame();
  json["frames"][0]["transform_matrix"] = {{1, 0}, {0, 1}};
  expect_rejected(json, "4×4");
  json["frames"][0]["transform_matrix"] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, -1, 0}, {0, 0, 0, 1}};
  expect_rejected(json, "transform_matrix");
  json["frames"][0]["transform_matrix"] = {{1, 0, 0, nullptr}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
  expect_rejected(json, "not a number");
}

TEST_F(CameraFile, RefusesListsThatAreNone) {
  expect_rejected(Json::object(), "frames");
  expect_rejected(Json::array(), "frames");
  expect_rejected({{"frames", Json::array()}}, "frames");
  expect_rejected({{"frames", {3}}}, "object");
  Json twice = one_frame();
  twice["frames"].push_back(twice["frames"][0]);
  expect_rejected(twice, "twice");
  EXPECT_THROW(read_text("{\"frames\": ["), Error);
}

TEST_F(CameraFile, MissingFileIsAUsageError) {
  try {
    read_camera_file(folder_.path() / "nothing.json", clip_, warnings_);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kUsage);
  }
}

TEST_F(CameraFile, DistortionIsWarnedOfOnce) {
  Json json = one_frame();
  json["k1"] = 0.1;
  json["frames"].push_back(json["frames"][0]);
  json["frames"][1]["file_path"] = "right";
  EXPECT_EQ(read(json).size(), 2U);
  EXPECT_EQ(warnings_.sentences.size(), 1U);
}

} // namespace
} // namespace kinora::player
