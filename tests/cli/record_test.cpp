// kinora record, recover and validate, as a user runs them.
#include <algorithm>

#include "cli/run_kinora.h"
#include "host/frame_reader.h"
#include "host/plugin_table.h"

namespace kinora::test {
namespace {

class Record : public ::testing::Test {
protected:
  Said run(const std::vector<std::string>& words) { return run_kinora(folder_, words); }
  std::string path(const char* name) const { return (folder_.path() / name).string(); }

  TemporaryFolder folder_;
  std::string capture_ = KINORA_SAMPLES "/carry_box";
};

std::vector<std::byte> bytes_of(const KinoraImage& image) {
  std::vector<std::byte> out;
  const std::size_t row = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.channels) *
                          (image.pixel_type == KINORA_PIXEL_U16 ? 2 : 1);
  for (int v = 0; image.data != nullptr && v < image.height; ++v) {
    const auto* from = static_cast<const std::byte*>(image.data) + image.row_bytes * static_cast<std::size_t>(v);
    out.insert(out.end(), from, from + row);
  }
  return out;
}

/// The frames of `recording` are the first ones of `capture`, bit by bit; how many there are.
int expect_same_frames(const std::string& recording, const std::string& capture) {
  const host::PluginTable plugins = host::PluginTable::builtin();
  host::FrameReader recorded(plugins.recognise(recording), recording, {});
  host::FrameReader original(plugins.recognise(capture), capture, {});
  int count = 0;
  while (const auto a = recorded.next()) {
    const auto b = original.next();
    EXPECT_TRUE(b.has_value() && a->problem.empty()) << a->problem;
    if (!b) break;
    EXPECT_EQ(a->frame.time, b->frame.time);
    EXPECT_EQ(a->frame.depth_unit, b->frame.depth_unit);
    EXPECT_EQ(bytes_of(a->frame.color), bytes_of(b->frame.color));
    EXPECT_EQ(bytes_of(a->frame.depth), bytes_of(b->frame.depth));
    EXPECT_EQ(bytes_of(a->frame.labels), bytes_of(b->frame.labels));
    ++count;
  }
  return count;
}

TEST_F(Record, ReadsBackBitByBitAndIsSound) {
  const Said said = run({"record", capture_, path("r.mkv"), "--duration", "0.5"});
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_GE(expect_same_frames(path("r.mkv"), capture_), 10);
  EXPECT_EQ(run({"validate", path("r.mkv")}).code, 0);
  EXPECT_NE(run({"info", path("r.mkv")}).out.find("a recording"), std::string::npos);
}

TEST_F(Record, CutFileIsRecoveredUpToTheCut) {
  ASSERT_EQ(run({"record", capture_, path("r.mkv"), "--duration", "1.2"}).code, 0);
  fs::resize_file(path("r.mkv"), fs::file_size(path("r.mkv")) * 3 / 4);
  expect_error(run({"validate", path("r.mkv")}), 4, "kinora recover");
  const Said said = run({"recover", path("r.mkv"), path("saved.mkv")});
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_NE(said.out.find("Lost:"), std::string::npos);
  EXPECT_EQ(run({"validate", path("saved.mkv")}).code, 0);
  EXPECT_GE(expect_same_frames(path("saved.mkv"), capture_), 10);
}

TEST_F(Record, FlippedBitInAPictureIsFound) {
  ASSERT_EQ(run({"record", capture_, path("r.mkv"), "--duration", "0.3"}).code, 0);
  std::fstream file(path("r.mkv"), std::ios::in | std::ios::out | std::ios::binary);
  const auto middle = static_cast<std::streamoff>(fs::file_size(path("r.mkv")) / 2);
  file.seekg(middle);
  const char flipped = static_cast<char>(file.get() ^ 0x10);
  file.seekp(middle);
  file.put(flipped);
  file.close();
  expect_error(run({"validate", path("r.mkv")}), 4, "damaged");
}

TEST_F(Record, ExistingFileIsNotReplaced) {
  folder_.write("r.mkv", "precious");
  expect_error(run({"record", capture_, path("r.mkv")}), 5, "--overwrite");
  EXPECT_EQ(contents_of(path("r.mkv")), "precious");
}

} // namespace
} // namespace kinora::test
