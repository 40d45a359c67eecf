#include <nlohmann/json.hpp>

#include <gtest/gtest.h>

#include "core/error.h"
#include "formats/sample_capture.h"
#include "rgbd_folder/folder_reader.h"

namespace kinora::formats {
namespace {

using Json = nlohmann::json;
using test::TemporaryFolder;

/// As nerfstudio writes it: the camera of frame i stands i metres to the right and looks along the world's -z.
Json sample_json(int frames) {
  Json json = {{"w", 16}, {"h", 12}, {"fl_x", 20}, {"fl_y", 21}, {"cx", 8}, {"cy", 6}, {"frames", Json::array()}};
  for (int i = 0; i < frames; ++i) {
    const std::string number = std::to_string(i);
    json["frames"].push_back({{"file_path", "images/" + number + ".png"},
                              {"depth_file_path", "depths/" + number + ".png"},
                              {"transform_matrix", {{1, 0, 0, i}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}}});
  }
  return json;
}

class TransformsTest : public testing::Test {
protected:
  TransformsTest() {
    for (int i = 0; i < 3; ++i) {
      folder_.write("images/" + std::to_string(i) + ".png", test::color_bytes(i));
      folder_.write("depths/" + std::to_string(i) + ".png", test::depth_bytes(i));
    }
  }
  Listing list(const Json& json) {
    folder_.write("transforms.json", json.dump());
    return list_transforms(folder_.path());
  }
  int confidence() const {
    KinoraProbe answer{};
    probe_transforms(folder_.path().c_str(), &answer);
    return answer.confidence;
  }
  void expect_refused(const std::string& text, const std::string& word) {
    folder_.write("transforms.json", text);
    EXPECT_GE(confidence(), 50) << "it is of this format, but broken";
    try {
      list_transforms(folder_.path());
      ADD_FAILURE() << text;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kCorruptInput);
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
    }
  }
  TemporaryFolder folder_;
};

TEST_F(TransformsTest, AxesAndPixelCentresBecomeOurs) {
  const Listing listing = list(sample_json(3));
  EXPECT_GE(confidence(), 50);
  EXPECT_EQ(listing.calibration.intrinsics, (Intrinsics{16, 12, 20, 21, 7.5, 5.5}));
  ASSERT_EQ(listing.frames.size(), 3U);
  const SE3 pose = listing.frames[2].camera_to_world.value();
  EXPECT_TRUE((pose * Eigen::Vector3d(0, 0, 1)).isApprox(Eigen::Vector3d(2, 0, -1)));
  EXPECT_TRUE((pose * Eigen::Vector3d(0, 1, 0)).isApprox(Eigen::Vector3d(2, -1, 0)));
}

TEST_F(TransformsTest, DepthComesThroughToTheBit) {
  FolderReader reader(list(sample_json(3)), folder_.path(), true);
  KinoraFrame frame{};
  for (int i = 0; i < 3; ++i) {
    ASSERT_EQ(reader.next(frame), KINORA_OK);
    const DepthImage16 truth = decode_depth16(test::depth_bytes(i), "truth");
    EXPECT_EQ(std::memcmp(frame.depth.data, truth.data(), truth.pixel_count() * 2), 0);
    EXPECT_EQ(frame.depth_unit, 0.001);
    EXPECT_EQ(frame.has_pose, 1);
  }
  EXPECT_EQ(reader.next(frame), KINORA_END);
}

TEST_F(TransformsTest, InstantNgpsNamesAndUnitsAreKnown) {
  Json json = sample_json(2);
  json["integer_depth_scale"] = 0.00025;
  for (Json& frame : json["frames"]) {
    frame["depth_path"] = frame["depth_file_path"];
    frame.erase("depth_file_path");
    frame["file_path"] = frame["file_path"].get<std::string>().substr(0, 8); // without extension
  }
  const Listing listing = list(json);
  EXPECT_EQ(listing.calibration.depth_unit, 0.00025);
  EXPECT_EQ(listing.frames[1].color, folder_.path() / "images/1.png");
  EXPECT_TRUE(listing.frames[1].problem.empty());
}

TEST_F(TransformsTest, TimesThatRunBackwardsArePutInOrderWithAWarning) {
  Json json = sample_json(3);
  for (int i = 0; i < 3; ++i) json["frames"][i]["time"] = 1 - 0.1 * i;
  const Listing listing = list(json);
  EXPECT_EQ(listing.frames.front().time, 0.8);
  ASSERT_EQ(listing.warnings.size(), 1U);
}

TEST_F(TransformsTest, FramesThatCannotBeUsedAreNamedAndTheRestIsRead) {
  Json json = sample_json(3);
  json["frames"][0].erase("depth_file_path");
  json["frames"][1]["transform_matrix"][0][0] = 3; // a scale
  const Listing listing = list(json);
  EXPECT_NE(listing.frames[0].problem.find("frame 0"), std::string::npos);
  EXPECT_NE(listing.frames[1].problem.find("frame 1"), std::string::npos);
  EXPECT_TRUE(listing.frames[2].problem.empty());
}

TEST_F(TransformsTest, DamagedFilesAreRefusedAtEveryLength) {
  const std::string whole = sample_json(3).dump();
  for (std::size_t tenth = 0; tenth < 10; ++tenth) expect_refused(whole.substr(0, whole.size() * tenth / 10), "frames");
  Json json = sample_json(1);
  json["w"] = 1e9;
  expect_refused(json.dump(), "absurd");
  json = sample_json(1);
  json.erase("fl_x");
  expect_refused(json.dump(), "focal length");
}

TEST_F(TransformsTest, WithoutDepthItIsNoCapture) {
  Json json = sample_json(1);
  json["frames"][0].erase("depth_file_path");
  folder_.write("transforms.json", json.dump());
  EXPECT_LT(confidence(), 50);
  EXPECT_GT(confidence(), 0);
}

} // namespace
} // namespace kinora::formats
