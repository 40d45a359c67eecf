#include "common/calibration.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "formats/sample_capture.h"

namespace kinora::formats {
namespace {

using test::TemporaryFolder;

class CalibrationTest : public testing::Test {
protected:
  Calibration read() const { return read_calibration({folder_.path()}); }

  void expect_refused(const std::string& name, const std::string& text, const std::string& word) const {
    folder_.write(name, text);
    try {
      read();
      ADD_FAILURE() << text << " was accepted";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kCorruptInput);
      EXPECT_NE(std::string(error.what()).find((folder_.path() / name).string()), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
    }
    folder_.remove(name);
  }

  TemporaryFolder folder_;
};

TEST_F(CalibrationTest, JsonGivesAllThatItSays) {
  folder_.write("intrinsics.json", R"({"width": 640, "height": 480, "fx": 525.5, "fy": 526, "cx": 319.5, "cy": 239.5,
    "depth_factor": 5000, "fps": 24, "distortion": [0.1, -0.2, 0.001, 0.002, 0.05]})");
  const Calibration calibration = read();
  EXPECT_EQ(calibration.intrinsics, (Intrinsics{640, 480, 525.5, 526, 319.5, 239.5}));
  EXPECT_DOUBLE_EQ(calibration.depth_unit.value(), 1.0 / 5000);
  EXPECT_EQ(calibration.frames_per_second, 24);
  EXPECT_EQ(calibration.distortion.k2, -0.2);
  EXPECT_EQ(calibration.distortion.k3, 0.05);
}

TEST_F(CalibrationTest, DepthScaleIsInMetres) {
  folder_.write("intrinsics.json", R"({"fx": 500, "fy": 500, "cx": 1, "cy": 1, "depth_scale_m": 0.00025})");
  EXPECT_DOUBLE_EQ(read().depth_unit.value(), 0.00025);
}

TEST_F(CalibrationTest, MatricesOfThreeAndFourRowsAreRead) {
  folder_.write("intrinsics.txt", "5.75e+02 0 3.2e+02 0\r\n0 5.77e+02 2.36e+02 0\r\n0 0 1 0\r\n0 0 0 1\r\n");
  EXPECT_EQ(read().intrinsics, (Intrinsics{0, 0, 575, 577, 320, 236}));
  folder_.remove("intrinsics.txt");
  folder_.write("camera-intrinsics.txt", " 5.85e+02\t 0\t 3.2e+02\t\n 0\t 5.86e+02\t 2.4e+02\t\n 0\t 0\t 1\t\n");
  EXPECT_EQ(read().intrinsics, (Intrinsics{0, 0, 585, 586, 320, 240}));
}

/// As Open3D and its recorder of RealSense cameras write it, column by column.
TEST_F(CalibrationTest, Open3dsMatrixIsRead) {
  const std::string text =
      R"({"width": 640, "height": 480, "intrinsic_matrix": [525.5, 0, 0, 0, 526, 0, 319.5, 239.5, 1],
    "depth_scale": 4000, "fps": 15})";
  for (const char* name : {"intrinsic.json", "camera_intrinsic.json", "camera_primesense.json"}) {
    folder_.write(name, text);
    EXPECT_EQ(read().intrinsics, (Intrinsics{640, 480, 525.5, 526, 319.5, 239.5}));
    EXPECT_EQ(read().depth_unit, 0.00025);
    EXPECT_EQ(read().frames_per_second, 15);
    folder_.remove(name);
  }
  expect_refused("intrinsic.json", R"({"intrinsic_matrix": [525, 0, 319, 0, 525, 239]})", "9 numbers");
  expect_refused("intrinsic.json", R"({"intrinsic_matrix": [525, 0, 0, 0, "x", 0, 319, 239, 1]})", "9 numbers");
  expect_refused("intrinsic.json", R"({"intrinsic_matrix": [0, 0, 0, 0, 525, 0, 319, 239, 1]})", "positive");
}

TEST_F(CalibrationTest, AbsenceIsAnErrorThatSaysWhatToAdd) {
  try {
    read();
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kCorruptInput);
    EXPECT_NE(std::string(error.what()).find("add intrinsics.json"), std::string::npos);
  }
}

TEST_F(CalibrationTest, DamagedAndAbsurdJsonIsRefused) {
  const std::string rest = R"("fy": 500, "cx": 1, "cy": 1)";
  expect_refused("intrinsics.json", "", "JSON");
  expect_refused("intrinsics.json", "{\"fx\": 5", "JSON");
  expect_refused("intrinsics.json", "[1, 2]", "JSON");
  expect_refused("intrinsics.json", "{" + rest + "}", "\"fx\" is missing");
  expect_refused("intrinsics.json", "{\"fx\": \"wide\", " + rest + "}", "must be a number");
  expect_refused("intrinsics.json", "{\"fx\": -500, " + rest + "}", "positive");
  expect_refused("intrinsics.json", "{\"fx\": 500, \"width\": -3, " + rest + "}", "\"width\" is absurd");
  expect_refused("intrinsics.json", "{\"fx\": 500, \"height\": 1e300, " + rest + "}", "\"height\" is absurd");
  expect_refused("intrinsics.json", "{\"fx\": 500, \"depth_factor\": 0, " + rest + "}", "\"depth_factor\" is absurd");
  expect_refused("intrinsics.json", "{\"fx\": 500, \"distortion\": [1, 2, 3, 4, 5, 6], " + rest + "}", "k1 k2");
  expect_refused("intrinsics.json", "{\"fx\": 500, \"distortion\": [1e9], " + rest + "}", "absurd");
  expect_refused("intrinsics.json", "{\"fx\": 500, \"depth_registered_to_color\": false, " + rest + "}", "register");
}

TEST_F(CalibrationTest, TextThatIsNoCameraMatrixIsRefused) {
  expect_refused("intrinsics.txt", "", "3x3 or 4x4");
  expect_refused("intrinsics.txt", "500 0 320 0 500 240 0 0", "3x3 or 4x4");
  expect_refused("intrinsics.txt", "500 0 320 0 500 240 0 zero 1", "\"zero\" is not a number");
  expect_refused("intrinsics.txt", "nan 0 320 0 500 240 0 0 1", "finite");
  expect_refused("intrinsics.txt", "0 0 320 0 500 240 0 0 1", "positive");
  expect_refused("intrinsics.txt", "500 0 320 7 500 240 0 0 1", "camera matrix");
}

} // namespace
} // namespace kinora::formats
