// Recordings as k4arecorder makes them, muxed by ffmpeg: tracks COLOR, DEPTH and IR, and an attached calibration.json.
#include <cstdlib>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "azure_kinect/kinect_calibration.h"
#include "core/error.h"
#include "formats/damage.h"

namespace kinora::formats {
namespace {

using test::CopiedCapture;
using test::TemporaryFolder;
using Json = nlohmann::json;
namespace fs = std::filesystem;

constexpr int kFrames = 3;

Json camera(const char* location, std::vector<double> parameters, double shift) {
  return {{"Location", location},
          {"MetricRadius", 1.7},
          {"Intrinsics",
           {{"ModelType", "CALIBRATION_LensDistortionModelBrownConrady"}, {"ModelParameters", std::move(parameters)}}},
          {"Rt", {{"Rotation", {1, 0, 0, 0, 1, 0, 0, 0, 1}}, {"Translation", {shift, 0, 0}}}}};
}

/// cx cy fx fy k1…k6 codx cody p2 p1, relative to the sensor.
std::string calibration_json(double k1) {
  const Json depth = camera("CALIBRATION_CameraLocationD0", {0.5, 0.5, 0.49, 0.49, k1, 0, 0, 0, 0, 0, 0, 0, 0, 0}, 0);
  const Json color =
      camera("CALIBRATION_CameraLocationPV0", {0.5, 0.5, 0.48, 0.64, k1, 0, 0, 0, 0, 0, 0, 0, 0, 0}, -0.032);
  return Json{{"CalibrationInformation", {{"Cameras", {depth, color}}}}}.dump();
}

class AzureKinectTest : public testing::Test {
protected:
  void SetUp() override { make(calibration_json(0)); }

  void make(const std::string& json) {
    folder_.write("calibration.json", json);
    // Depth of frame i is 1000 + 100 i everywhere.
    const std::string command =
        "cd '" + folder_.path().string() +
        "' && ffmpeg -v error -y -f lavfi -i testsrc=s=1280x720:r=30 -f lavfi -i "
        "\"color=black:s=320x288:r=30,format=gray16le,geq=lum='1000+100*N'\" -f lavfi -i "
        "\"color=black:s=320x288:r=30,format=gray16le,geq=lum='7'\" -map 0 -map 1 -map 2 -t 0.1 -c:v:0 mjpeg -q:v "
        "2 "
        "-pix_fmt:v:0 yuvj420p -c:v:1 ffv1 -c:v:2 ffv1 -metadata:s:v:0 title=COLOR -metadata:s:v:1 title=DEPTH "
        "-metadata:s:v:2 title=IR -attach calibration.json -metadata:s:t mimetype=application/octet-stream "
        "-metadata K4A_DEPTH_MODE=NFOV_2X2BINNED r.mkv";
    if (std::system(command.c_str()) != 0) GTEST_SKIP() << "ffmpeg is not installed";
  }
  fs::path path() const { return folder_.path() / "r.mkv"; }
  void expect_refused(const std::string& word) {
    try {
      (void)test::read_capture(path(), "azure-kinect");
      ADD_FAILURE() << word;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kCorruptInput);
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
    }
  }

  TemporaryFolder folder_;
};

TEST_F(AzureKinectTest, ColourDepthInfraredAndBothCamerasAreRead) {
  const CopiedCapture capture = test::read_capture(path());
  EXPECT_EQ(capture.format, "azure-kinect");
  ASSERT_EQ(capture.frames.size(), static_cast<std::size_t>(kFrames));
  EXPECT_EQ(capture.info.camera.width, 1280);
  EXPECT_NEAR(capture.info.camera.fx, 0.48 * 1280, 1e-9);
  EXPECT_NEAR(capture.info.camera.cy, 0.5 * 960 - 120 - 0.5, 1e-9);
  EXPECT_NEAR(capture.info.depth_camera.cx, 0.5 * 512 - 96 - 0.5, 1e-9);
  EXPECT_NEAR(capture.info.depth_to_color[3], -0.032, 1e-12);
  for (int i = 0; i < kFrames; ++i) {
    const test::CopiedFrame& frame = capture.frames[static_cast<std::size_t>(i)];
    EXPECT_EQ(frame.problem, "");
    EXPECT_NEAR(frame.time, i / 30.0, 2e-3); // Matroska counts milliseconds
    const auto* depth = reinterpret_cast<const std::uint16_t*>(frame.depth.data());
    EXPECT_EQ(depth[100 * 320 + 100], 1000 + 100 * i);
    EXPECT_EQ(reinterpret_cast<const std::uint16_t*>(frame.infrared.data())[5000], 7);
    EXPECT_FALSE(frame.color.empty());
  }
}

/// Raw with the first byte the higher one, under the four letters b16g, which ffmpeg does not write.
TEST_F(AzureKinectTest, DepthAsTheRecorderStoresItIsReadAlsoAfterMkvmerge) {
  const auto in_folder = [&](const std::string& command) {
    return std::system(("cd '" + folder_.path().string() + "' && " + command).c_str()) == 0;
  };
  ASSERT_TRUE(in_folder("ffmpeg -v error -y -i r.mkv -map 0 -c copy -c:v:1 rawvideo -pix_fmt:v:1 gray16be "
                        "-allow_raw_vfw 1 raw.mkv"));
  std::ifstream in(folder_.path() / "raw.mkv", std::ios::binary);
  std::string file{std::istreambuf_iterator<char>(in), {}};
  const std::uint32_t start[] = {40, 320}; // of Windows' BITMAPINFOHEADER: its size, and the width
  const std::size_t head = file.find(std::string(reinterpret_cast<const char*>(start), sizeof start));
  ASSERT_NE(head, std::string::npos);
  const std::int32_t height = 288;
  std::memcpy(file.data() + head + 8, &height, sizeof height);
  file.replace(head + 16, 4, "b16g");
  folder_.write("r.mkv", file);
  for (int i = 0; i < 2; ++i) {
    const CopiedCapture capture = test::read_capture(path());
    ASSERT_EQ(capture.frames.size(), static_cast<std::size_t>(kFrames));
    for (std::size_t k = 0; k < capture.frames.size(); ++k)
      EXPECT_EQ(reinterpret_cast<const std::uint16_t*>(capture.frames[k].depth.data())[5000], 1000 + 100 * k);
    if (!in_folder("mkvmerge -q -o merged.mkv r.mkv && mv merged.mkv r.mkv")) GTEST_SKIP() << "no mkvmerge";
  }
}

TEST_F(AzureKinectTest, DamagedFilesAreRefusedAtEveryLength) {
  test::expect_bears_truncation(path(), path(), "azure-kinect", kFrames);
}

TEST_F(AzureKinectTest, ACalibrationThatIsNoneIsRefused) {
  for (const char* text : {"", "{}", "[1, 2]", R"({"CalibrationInformation": {"Cameras": [{"Location": 3}]}})"}) {
    make(std::string(text) + " ");
    expect_refused("calibration.json");
  }
  make(calibration_json(1e9));
  expect_refused("absurd");
}

TEST(KinectLens, AStraightenedPictureHasStraightLines) {
  // A picture as a lens with k1 = 0.2 sees the line x/z = 0.3; straightened, the line is one column.
  RationalLens lens;
  lens.intrinsics = {201, 201, 100, 100, 100, 100};
  lens.k[0] = 0.2;
  DepthImage16 seen(201, 201);
  for (double y = -0.9; y <= 0.9; y += 0.001) {
    const double d = 1 + 0.2 * (0.3 * 0.3 + y * y);
    const int u = static_cast<int>(std::round(100 * 0.3 * d + 100));
    const int v = static_cast<int>(std::round(100 * y * d + 100));
    if (seen.contains(u, v)) seen.at(u, v) = 500;
  }
  const DepthImage16 straight = LensMap(lens).straighten(seen);
  int on_line = 0;
  for (int v = 30; v <= 170; ++v)
    for (int u = 0; u < 201; ++u)
      if (straight.at(u, v) == 500) {
        EXPECT_NEAR(u, 130, 1) << v;
        ++on_line;
      }
  EXPECT_GT(on_line, 130);
}

} // namespace
} // namespace kinora::formats
