// EXR files, read back by the OpenEXR library.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDeepFrameBuffer.h>
#include <OpenEXR/ImfDeepScanLineInputFile.h>
#include <OpenEXR/ImfDoubleAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
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

TEST_F(ExrTest, ViewsOfOneTimeAreNamedPartsOfOneFile) {
  const fs::path folder = folder_.path() / "views";
  host::PictureWriter writer(table_.find("exr"), folder, {{"views", "parts"}});
  for (int i = 0; i < 4; ++i) {
    Picture given = picture();
    given.name = i % 2 == 0 ? "left" : "right";
    given.time = i < 2 ? 0 : 0.5;
    given.color = sample_color(kWidth, kHeight, 4, i);
    writer.write(given);
    EXPECT_EQ(fs::exists(folder / "000000.exr"), i >= 2) << "it is whole when the next time begins";
  }
  writer.finish();
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 2);
  Imf::MultiPartInputFile file((folder / "000001.exr").c_str());
  ASSERT_EQ(file.parts(), 2);
  EXPECT_EQ(file.header(0).name(), "left");
  EXPECT_EQ(file.header(1).view(), "right");
  EXPECT_EQ(file.header(1).typedAttribute<Imf::DoubleAttribute>("time").value(), 0.5);
  Imf::InputPart part(file, 1);
  std::vector<float> alpha(kWidth * kHeight);
  Imf::FrameBuffer buffer;
  buffer.insert("A",
                Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(alpha.data()), sizeof(float), sizeof(float) * kWidth));
  part.setFrameBuffer(buffer);
  part.readPixels(0, kHeight - 1);
  const ColorImage expected = sample_color(kWidth, kHeight, 4, 3);
  for (std::size_t i = 0; i < alpha.size(); ++i) EXPECT_NEAR(alpha[i], expected.data()[4 * i + 3] / 255.0, 1e-3);
}

TEST_F(ExrTest, ViewsOfAnEarlierTimeOrAnotherSizeAreRefused) {
  host::PictureWriter writer(table_.find("exr"), folder_.path() / "views", {{"views", "parts"}});
  writer.write(picture());
  Picture early = picture();
  early.time = 0;
  EXPECT_THROW(writer.write(early), Error);
  writer.write({"small", 1.5, sample_color(2, 2, 4, 1), {}});
  EXPECT_THROW(writer.finish(), Error);
}

/// Two layers, the second of which is nearer at the right.
TEST_F(ExrTest, DeepPicturesHaveASampleForEachLayerFromNearToFar) {
  Picture given = picture();
  const std::vector<host::LabelMeaning> meanings{{1, "person", "deforming"}, {2, "object", "rigid"}};
  for (std::size_t l = 0; l < 2; ++l) {
    Picture layer{meanings[l].name, 1.5, ColorImage(kWidth, kHeight, 4, 255), {}};
    layer.metric_depth = DepthImage(kWidth, kHeight, 1, 2);
    layer.label_meanings = std::span(&meanings[l], 1);
    for (int u = 0; u < kWidth && l == 1; ++u) layer.metric_depth.at(u, 3) = u < 3 ? 3.0F : 1.0F;
    layer.color.at(0, 0, 3) = 0;   // nothing of either
    layer.color.at(1, 0, 3) = 102; // too thin for a depth of its own
    layer.metric_depth.at(1, 0) = 0;
    given.layers.push_back(std::move(layer));
  }
  const fs::path path = write(given).replace_extension(".deep.exr");
  Imf::DeepScanLineInputFile file(path.c_str());
  EXPECT_EQ(file.header().typedAttribute<Imf::DoubleAttribute>("time").value(), 1.5);
  std::vector<unsigned> counts(kWidth * kHeight);
  Imf::DeepFrameBuffer buffer;
  buffer.insertSampleCountSlice(
      Imf::Slice(Imf::UINT, reinterpret_cast<char*>(counts.data()), sizeof(unsigned), sizeof(unsigned) * kWidth));
  std::vector<std::array<float, 2>> depth(kWidth * kHeight), alpha(kWidth * kHeight), id(kWidth * kHeight);
  const auto insert = [&buffer](const char* name, std::vector<std::array<float, 2>>& values, std::vector<float*>& at) {
    for (auto& value : values) at.push_back(value.data());
    buffer.insert(name, Imf::DeepSlice(Imf::FLOAT, reinterpret_cast<char*>(at.data()), sizeof(float*),
                                       sizeof(float*) * kWidth, sizeof(float)));
  };
  std::vector<float*> depth_at, alpha_at, id_at;
  insert("Z", depth, depth_at);
  insert("A", alpha, alpha_at);
  insert("id", id, id_at);
  file.setFrameBuffer(buffer);
  file.readPixelSampleCounts(0, kHeight - 1);
  file.readPixels(0, kHeight - 1);
  EXPECT_EQ(counts[0], 0U);
  EXPECT_EQ(counts[1], 2U);
  EXPECT_NEAR(alpha[1][0], 0.4F, 1e-3F);
  EXPECT_EQ(depth[1][0], 2) << "that of the pixels beside it";
  EXPECT_EQ(depth[3 * kWidth + 1], (std::array<float, 2>{2, 3}));
  EXPECT_EQ(id[3 * kWidth + 1], (std::array<float, 2>{1, 2}));
  EXPECT_EQ(depth[3 * kWidth + 4], (std::array<float, 2>{1, 2}));
  EXPECT_EQ(id[3 * kWidth + 4], (std::array<float, 2>{2, 1}));
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
