// The formats that write, through the host as every caller uses them.
#include <gtest/gtest.h>

#include <cstdlib>

#include "core/error.h"
#include "formats/sample_capture.h"
#include "host/picture_writer.h"
#include "host/plugin_table.h"

namespace kinora::formats {
namespace {

using namespace kinora::test;
using host::Picture;
using host::PictureWriter;

Bytes read_bytes(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(file)), {});
  const auto view = std::as_bytes(std::span(text));
  return {view.begin(), view.end()};
}

template <class Call> void expect_error(ErrorCode code, const std::string& word, const Call& call) {
  try {
    call();
    ADD_FAILURE() << "nothing was thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
  }
}

class WriterTest : public testing::Test {
protected:
  PictureWriter open(const std::string& format, const fs::path& name, const host::Options& options = {}) {
    return {table_.find(format), folder_.path() / name, options};
  }

  static Picture picture(int number, int channels = 4, int width = 20, int height = 14) {
    return {"view_" + std::to_string(number), number / 30.0,
            sample_color(width, height, channels, static_cast<std::uint64_t>(number)), sample_depth(width, height)};
  }

  TemporaryFolder folder_;
  host::PluginTable table_ = host::PluginTable::builtin();
};

using PngWriterTest = WriterTest;
using Mp4WriterTest = WriterTest;

TEST_F(PngWriterTest, FolderHoldsOnePictureAndItsDepthPerName) {
  PictureWriter writer = open("png", "out");
  writer.write(picture(0));
  Picture nested = picture(1);
  nested.name = "a/b/c.d";
  nested.depth = {};
  writer.write(nested);
  writer.finish();
  const Bytes color = read_bytes(folder_.path() / "out/view_0.png");
  EXPECT_EQ(color, encode_png(picture(0).color));
  EXPECT_EQ(read_bytes(folder_.path() / "out/view_0.depth.png"), encode_png16(picture(0).depth));
  EXPECT_TRUE(fs::exists(folder_.path() / "out/a/b/c.d.png"));
  EXPECT_FALSE(fs::exists(folder_.path() / "out/a/b/c.d.depth.png"));
}

// Red to the right, green up, blue towards the camera; where there is no normal, black.
TEST_F(PngWriterTest, NormalsAndConfidenceStandBesideTheColour) {
  Picture given = picture(0, 4, 4, 1);
  given.normal = Image<float>(4, 1, 3);
  const float normals[] = {0, 0, -1, 1, 0, 0, 0, -1, 0, 0, 0, 0};
  std::copy(std::begin(normals), std::end(normals), given.normal.data());
  given.confidence = Image<std::uint8_t>(4, 1, 1, 77);
  PictureWriter writer = open("png", "still.png");
  writer.write(given);
  writer.finish();
  ColorImage colors(4, 1, 3);
  const std::uint8_t expected[] = {128, 128, 255, 255, 128, 128, 128, 255, 128, 0, 0, 0};
  std::copy(std::begin(expected), std::end(expected), colors.data());
  EXPECT_EQ(read_bytes(folder_.path() / "still.normal.png"), encode_png(colors));
  EXPECT_EQ(read_bytes(folder_.path() / "still.confidence.png"), encode_png(given.confidence));
}

TEST_F(PngWriterTest, SingleFileIsWrittenToExactlyThePathGiven) {
  for (const char* name : {"still.png", "still.png.part"}) {
    PictureWriter writer = open("png", name);
    writer.write(picture(0));
    writer.finish();
    EXPECT_EQ(read_bytes(folder_.path() / name), encode_png(picture(0).color));
  }
  EXPECT_TRUE(fs::exists(folder_.path() / "still.depth.png"));
  EXPECT_TRUE(fs::exists(folder_.path() / "still.depth.png.part"));
}

TEST_F(PngWriterTest, SingleFileTakesOnePicture) {
  PictureWriter writer = open("png", "odd name", {{"layout", "file"}});
  writer.write(picture(0));
  EXPECT_TRUE(fs::is_regular_file(folder_.path() / "odd name"));
  expect_error(ErrorCode::kUsage, "folder", [&] { writer.write(picture(1)); });
  PictureWriter empty = open("png", "none.png");
  expect_error(ErrorCode::kFailure, "no picture", [&] { empty.finish(); });
}

TEST_F(PngWriterTest, NamesThatLeaveTheFolderAreRefused) {
  PictureWriter writer = open("png", "out");
  for (const char* name : {"../x", "a/../../x", "/tmp/x", ""}) {
    Picture escaping = picture(0);
    escaping.name = name;
    expect_error(ErrorCode::kUsage, "leaves the output folder", [&] { writer.write(escaping); });
  }
}

TEST_F(PngWriterTest, UnwritablePlacesAreErrorsThatNameThem) {
  folder_.write("file", "in the way");
  expect_error(ErrorCode::kUnwritableOutput, "file", [&] { open("png", "file/out"); });
  expect_error(ErrorCode::kUnwritableOutput, "absent", [&] { open("png", "absent/x.png"); });
  expect_error(ErrorCode::kUnwritableOutput, "/dev/full", [&] {
    PictureWriter full(table_.find("png"), "/dev/full", {{"layout", "file"}});
    full.write(picture(0));
  });
}

TEST_F(Mp4WriterTest, SamePicturesGiveTheSameBytes) {
  for (const char* name : {"a.mp4", "b.mp4", "a.webm", "b.webm.2.part"}) {
    PictureWriter writer = open("mp4", name);
    for (int i = 0; i < 5; ++i) writer.write(picture(i));
    writer.finish();
  }
  const Bytes film = read_bytes(folder_.path() / "a.mp4");
  ASSERT_GT(film.size(), 1000U);
  EXPECT_EQ(film, read_bytes(folder_.path() / "b.mp4"));
  EXPECT_EQ(static_cast<char>(film[4]), 'f'); // "ftyp" is the first box of every MP4
  const Bytes web = read_bytes(folder_.path() / "a.webm");
  ASSERT_GT(web.size(), 500U);
  EXPECT_EQ(web, read_bytes(folder_.path() / "b.webm.2.part"));
  EXPECT_EQ(static_cast<std::uint8_t>(web[0]), 0x1A); // the first byte of every Matroska file
}

TEST_F(Mp4WriterTest, FfprobeCountsThePictures) {
  if (std::system("ffprobe -version > /dev/null 2>&1") != 0) GTEST_SKIP() << "ffprobe is not installed";
  for (const auto& [name, codec] : {std::pair("a.mp4", "h264"), std::pair("a.webm", "vp9")}) {
    PictureWriter writer = open("mp4", name);
    for (int i = 0; i < 5; ++i) writer.write(picture(i));
    writer.finish();
    const fs::path said = folder_.path() / "said.txt";
    const std::string command =
        "ffprobe -v error -count_frames -show_entries stream=codec_name,width,height,nb_read_frames -of csv '" +
        (folder_.path() / name).string() + "' > '" + said.string() + "' 2>&1";
    ASSERT_EQ(std::system(command.c_str()), 0);
    const Bytes bytes = read_bytes(said);
    EXPECT_EQ(std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()),
              std::string("stream,") + codec + ",20,14,5\n");
  }
}

TEST_F(Mp4WriterTest, OddSizesAndSingleFramesAreFine) {
  PictureWriter writer = open("mp4", "odd.mp4", {{"fps", "24"}, {"crf", "30"}});
  writer.write(picture(0, 3, 21, 13));
  writer.finish();
  EXPECT_GT(fs::file_size(folder_.path() / "odd.mp4"), 500U);
}

TEST_F(Mp4WriterTest, PicturesThatMakeNoFilmAreRefused) {
  PictureWriter writer = open("mp4", "a.mp4");
  writer.write(picture(3));
  expect_error(ErrorCode::kUsage, "increase", [&] { writer.write(picture(3)); });
  expect_error(ErrorCode::kUsage, "same size", [&] { writer.write(picture(4, 4, 22, 14)); });
  PictureWriter empty = open("mp4", "b.mp4");
  expect_error(ErrorCode::kFailure, "at least one picture", [&] { empty.finish(); });
  expect_error(ErrorCode::kUsage, "crf from 0 to 51", [&] { open("mp4", "c.mp4", {{"crf", "52"}}); });
}

TEST_F(Mp4WriterTest, UnwritablePlacesAreErrorsThatNameThem) {
  expect_error(ErrorCode::kUnwritableOutput, "absent", [&] { open("mp4", "absent/a.mp4"); });
  expect_error(ErrorCode::kUnwritableOutput, "/dev/full", [&] {
    PictureWriter full(table_.find("mp4"), "/dev/full", {});
    for (int i = 0; i < 3; ++i) full.write(picture(i));
    full.finish();
  });
}

} // namespace
} // namespace kinora::formats
