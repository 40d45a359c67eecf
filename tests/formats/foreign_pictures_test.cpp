// Folders whose pictures FFmpeg wrote: colour as PNG and as JPEG, depth as 16-bit PNG.
#include <cstdlib>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "formats/capture_frames.h"
#include "formats/sample_capture.h"

namespace kinora::test {
namespace {

constexpr int kWidth = 48;
constexpr int kHeight = 32;
constexpr int kFrames = 3;

int depth_at(int u, int v, int frame) { return 1000 + 10 * u + 3 * v + 100 * frame; }
int color_at(int u, int v, int channel, int frame) { return channel == 0 ? 3 * u : channel == 1 ? 4 * v : 40 * frame; }

class ForeignPictures : public testing::Test {
protected:
  /// c0.png, c0.jpg, d0.png and so on in the folder `to` of the capture.
  bool write_pictures(const std::string& to, const std::string& color, const std::string& depth) const {
    std::filesystem::create_directories(folder_.path() / to);
    const std::string in = "cd '" + (folder_.path() / to).string() + "' && ffmpeg -v error -y -f lavfi -i ";
    const std::string size = fmt::format("s={}x{}:r=25:d={}", kWidth, kHeight, kFrames / 25.0);
    const std::string end = fmt::format(" -frames:v {} -start_number 0 ", kFrames);
    return std::system((in + "\"color=" + size + ",format=gbrp,geq=r='3*X':g='4*Y':b='40*N',format=rgb24\"" + end +
                        "-q:v 1 " + color)
                           .c_str()) == 0 &&
           std::system((in + "\"color=" + size + ",format=gray16le,geq=lum='1000+10*X+3*Y+100*N',format=gray16be\"" +
                        end + depth)
                           .c_str()) == 0;
  }
  void expect_read(const char* format, double tolerance) const {
    const CopiedCapture capture = read_capture(folder_.path());
    EXPECT_EQ(capture.format, format);
    ASSERT_EQ(capture.frames.size(), std::size_t{kFrames});
    for (int i = 0; i < kFrames; ++i) {
      const CopiedFrame& frame = capture.frames[static_cast<std::size_t>(i)];
      ASSERT_EQ(frame.problem, "");
      const auto* depth = reinterpret_cast<const std::uint16_t*>(frame.depth.data());
      for (int v = 0; v < kHeight; ++v) {
        for (int u = 0; u < kWidth; ++u) {
          const int pixel = v * kWidth + u;
          ASSERT_EQ(depth[pixel], depth_at(u, v, i)) << u << " " << v << " " << i;
          for (int c = 0; c < 3; ++c)
            ASSERT_NEAR(std::to_integer<int>(frame.color[static_cast<std::size_t>(3 * pixel + c)]),
                        color_at(u, v, c, i), tolerance)
                << u << " " << v << " " << i;
        }
      }
    }
  }
  void write_intrinsics() const {
    folder_.write("intrinsics.json", R"({"fx": 40, "fy": 40, "cx": 23.5, "cy": 15.5, "width": 48, "height": 32})");
  }

  TemporaryFolder folder_;
};

TEST_F(ForeignPictures, OfANumberedFolderAreReadToTheBit) {
  if (!write_pictures("color", "%d.png", "../d%d.png")) GTEST_SKIP() << "ffmpeg is not installed";
  std::filesystem::create_directories(folder_.path() / "depth");
  for (int i = 0; i < kFrames; ++i)
    std::filesystem::rename(folder_.path() / fmt::format("d{}.png", i),
                            folder_.path() / fmt::format("depth/{}.png", i));
  write_intrinsics();
  expect_read("numbered-folder", 0);
}

TEST_F(ForeignPictures, OfTumAre) {
  if (!write_pictures("rgb", "%d.png", "d%d.png")) GTEST_SKIP() << "ffmpeg is not installed";
  write_intrinsics();
  std::string list;
  for (int i = 0; i < kFrames; ++i) list += fmt::format("{0}.04 rgb/{1}.png {0}.05 rgb/d{1}.png\n", 100 + i, i);
  folder_.write("associations.txt", list);
  expect_read("tum-rgbd", 0);
}

TEST_F(ForeignPictures, Of3dMatchAre) {
  if (!write_pictures(".", "frame-%06d.color.jpg", "frame-%06d.depth.png")) GTEST_SKIP() << "ffmpeg is not installed";
  folder_.write("camera-intrinsics.txt", "40 0 23.5\n0 40 15.5\n0 0 1\n");
  expect_read("3dmatch", 12); // of JPEG with half the chroma
}

TEST_F(ForeignPictures, OfTransformsAre) {
  if (!write_pictures("images", "%d.png", "d%d.png")) GTEST_SKIP() << "ffmpeg is not installed";
  std::string frames;
  for (int i = 0; i < kFrames; ++i)
    frames += fmt::format(R"({}{{"file_path": "images/{}.png", "depth_file_path": "images/d{}.png", "transform_matrix":
      [[1, 0, 0, {}], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}})",
                          i > 0 ? "," : "", i, i, i);
  folder_.write("transforms.json",
                R"({"w": 48, "h": 32, "fl_x": 40, "fl_y": 40, "cx": 24, "cy": 16, "frames": [)" + frames + "]}");
  expect_read("transforms", 0);
}

} // namespace
} // namespace kinora::test
