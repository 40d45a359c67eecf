// EXR files, read back by the OpenEXR library.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDoubleAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStringAttribute.h>

#include "core/error.h"
#include "formats/sample_capture.h"
#include "host/picture_writer.h"
#include "host/plugin_table.h"

namespace kinora::formats {
namespace {

using namespace kinora::test;
using host::Picture;

constexpr int kWidth = 6;
constexpr int kHeight = 5;

class ExrTest : public testing::Test {
protected:
  static Picture picture() {
    Picture given{"view", 1.5, sample_color(kWidth, kHeight, 4, 3), {}};
    given.metric_depth = DepthImage(kWidth, kHeight, 1, 0);
    given.metric_depth.at(2, 1) = 1.2345678F;
    return given;
  }
  fs::path write(const Picture& given, const host::Options& options = {}) const {
    host::PictureWriter writer(table_.find("exr"), folder_.path() / "a.exr", options);
    writer.write(given);
    writer.finish();
    return folder_.path() / "a.exr";
  }
  /// A channel as floats, row by row.
  static std::vector<float> channel(const fs::path& path, const char* name) {
    Imf::InputFile file(path.c_str());
    std::vector<float> values(kWidth * kHeight, -1);
    Imf::FrameBuffer buffer;
    buffer.insert(
        name, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(values.data()), sizeof(float), sizeof(float) * kWidth));
    file.setFrameBuffer(buffer);
    file.readPixels(0, kHeight - 1);
    return values;
  }
  static std::vector<std::string> channel_names(const fs::path& path) {
    Imf::InputFile file(path.c_str());
    std::vector<std::string> names;
    const Imf::ChannelList& channels = file.header().channels();
    for (auto it = channels.begin(); it != channels.end(); ++it) names.emplace_back(it.name());
    return names;
  }

  TemporaryFolder folder_;
  host::PluginTable table_ = host::PluginTable::builtin();
};

TEST_F(ExrTest, ColoursAreLinearLightTimesAlpha) {
  const Picture given = picture();
  const fs::path path = write(given);
  const char* const names[] = {"R", "G", "B"};
  const std::vector<float> alpha = channel(path, "A");
  for (std::size_t c = 0; c < 3; ++c) {
    const std::vector<float> values = channel(path, names[c]);
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double v = given.color.data()[4 * i + c] / 255.0;
      const double a = given.color.data()[4 * i + 3] / 255.0;
      const double linear = v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
      EXPECT_NEAR(alpha[i], a, 1e-3);
      EXPECT_NEAR(values[i], linear * a, 1e-3 * linear + 1e-6);
    }
  }
}

TEST_F(ExrTest, DepthIsMetresToTheLastBitInEveryCompression) {
  for (const char* compression : {"zip", "piz", "none"}) {
    const std::vector<float> depth = channel(write(picture(), {{"compression", compression}}), "Z");
    EXPECT_EQ(depth[kWidth + 2], 1.2345678F);
    EXPECT_EQ(depth[0], 0);
  }
}

TEST_F(ExrTest, NormalsConfidenceAndLabelsStandInTheSameFile) {
  Picture given = picture();
  given.normal = Image<float>(kWidth, kHeight, 3);
  given.normal.pixel(1, 0)[1] = -1; // up
  given.normal.pixel(2, 0)[2] = -1; // towards the camera
  given.confidence = Image<std::uint8_t>(kWidth, kHeight, 1, 51);
  given.labels = LabelImage(kWidth, kHeight, 1, 2);
  const std::vector<host::LabelMeaning> meanings{{0, "background", "still"}, {2, "object", "rigid"}};
  given.label_meanings = meanings;
  const fs::path path = write(given);
  EXPECT_EQ(channel_names(path),
            (std::vector<std::string>{"A", "B", "G", "N.X", "N.Y", "N.Z", "R", "Z", "confidence", "id"}));
  EXPECT_EQ(channel(path, "N.Y")[1], 1);
  EXPECT_EQ(channel(path, "N.Z")[2], 1);
  EXPECT_NEAR(channel(path, "confidence")[7], 0.2F, 1e-3F);
  EXPECT_EQ(channel(path, "id")[7], 2);
  Imf::InputFile file(path.c_str());
  EXPECT_EQ(file.header().typedAttribute<Imf::StringAttribute>("labels").value(), "0 background, 2 object");
}

TEST_F(ExrTest, TheCameraAndTheTimeAreAttributes) {
  Picture given = picture();
  given.camera = Camera{{kWidth, kHeight, 50, 51, 2.5, 2}, SE3::Identity()};
  given.camera->camera_to_world.translation() = Eigen::Vector3d(1, 2, 3);
  Imf::InputFile file(write(given).c_str());
  // Axes there: y up, z back. The world's origin is at (-1, 2, 3) of such a camera.
  const Imath::V3f origin = Imath::V3f(0, 0, 0) * Imf::worldToCamera(file.header());
  EXPECT_EQ(origin, Imath::V3f(-1, 2, 3));
  const auto number = [&](const char* name) {
    return file.header().typedAttribute<Imf::DoubleAttribute>(name).value();
  };
  EXPECT_EQ(number("fl_y"), 51);
  EXPECT_EQ(number("cx"), 3) << "the first pixel has its centre at 0.5";
  EXPECT_EQ(number("time"), 1.5);
}

TEST_F(ExrTest, SamePicturesGiveTheSameBytes) {
  const auto bytes = [](const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  const std::string first = bytes(write(picture()));
  EXPECT_EQ(first, bytes(write(picture())));
}

TEST_F(ExrTest, TheLibrarysOwnProgramReadsTheHeader) {
  if (std::system("exrheader -v > /dev/null 2>&1") == 127 * 256) GTEST_SKIP() << "exrheader is not installed";
  EXPECT_EQ(std::system(("exrheader '" + write(picture()).string() + "' > /dev/null").c_str()), 0);
}

TEST_F(ExrTest, ImagesOfDifferentSizesAndUnwritablePlacesAreErrors) {
  Picture given = picture();
  given.metric_depth = DepthImage(kWidth, kHeight + 1);
  const auto code_of = [](const auto& call) {
    try {
      call();
    } catch (const Error& error) {
      return error.code();
    }
    return ErrorCode{};
  };
  EXPECT_EQ(code_of([&] { write(given); }), ErrorCode::kUsage);
  EXPECT_EQ(code_of([&] {
              host::PictureWriter writer(table_.find("exr"), "/dev/full", {{"layout", "file"}});
              writer.write(picture());
            }),
            ErrorCode::kUnwritableOutput);
}

} // namespace
} // namespace kinora::formats
