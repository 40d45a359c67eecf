// Damaged clips at the command line, and cutting and joining them.
#include <nlohmann/json.hpp>

#include "cli/run_kinora.h"
#include "clip/clip_io.h"
#include "clip/sample_clip.h"
#include "support/source_folder.h"

namespace kinora::test {
namespace {

class ClipFiles : public testing::Test {
protected:
  ClipFiles() { clip::write_clip(clip::testing::bending_clip(1, 40, true), path("clip.mkv")); }
  Said run(const std::vector<std::string>& words) const { return run_kinora(folder_, words); }
  std::string path(const std::string& name) const { return (folder_.path() / name).string(); }
  /// Without its last part, where the frames are.
  void cut_short() const { fs::resize_file(path("clip.mkv"), fs::file_size(path("clip.mkv")) - 4'000); }

  TemporaryFolder folder_;
};

int count_of(const std::string& text, const std::string& word) {
  int count = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++count;
  return count;
}

TEST_F(ClipFiles, CommandsReadWhatIsWholeOfACutClipAndWarnOnce) {
  cut_short();
  const std::vector<std::vector<std::string>> commands{{"info", path("clip.mkv")},
                                                       {"motion", path("clip.mkv"), "--out", path("m.json")},
                                                       {"render", path("clip.mkv"), path("o.png"), "--size", "16x12"}};
  for (const auto& words : commands) {
    const Said said = run(words);
    EXPECT_EQ(said.code, 0) << said.err;
    EXPECT_EQ(count_of(said.err, "warning:"), 1) << said.err;
    EXPECT_NE(said.err.find("cut short"), std::string::npos) << said.err;
    EXPECT_NE(said.err.find("frames "), std::string::npos) << said.err;
  }
  const auto info = nlohmann::json::parse(run({"info", path("clip.mkv"), "--json"}).out);
  EXPECT_LT(info["frames"].get<int>(), 40);
  EXPECT_FALSE(info["missing"].empty());
}

TEST_F(ClipFiles, StrictInfoAndValidateRefuseDamage) {
  EXPECT_EQ(run({"info", path("clip.mkv"), "--strict"}).code, 0);
  EXPECT_EQ(run({"validate", path("clip.mkv")}).code, 0);
  cut_short();
  expect_error(run({"info", path("clip.mkv"), "--strict"}), 4, "damaged");
  expect_error(run({"validate", path("clip.mkv")}), 4, "damaged");
}

TEST_F(ClipFiles, ASmallerClipHasTheBytesThatAreAskedForAndTheSameMotion) {
  const std::string clip = (source_folder() / "tests" / "conformance" / "clip_fields_3_and_4.mkv").string();
  const auto frames = static_cast<double>(clip::read_clip(clip).times.size());
  const auto bytes = [this](const char* name) { return static_cast<double>(fs::file_size(path(name))); };
  const auto make = [&](const char* name, double wanted) {
    const Said said = run({"cut", clip, path(name), "--kb-per-frame", std::to_string(wanted / frames / 1000)});
    EXPECT_EQ(said.code, 0) << said.err;
    return said.err;
  };
  EXPECT_NE(make("few.mkv", 1).find("less than the clip needs"), std::string::npos);
  EXPECT_NE(make("most.mkv", 1e9).find("more than the clip can use"), std::string::npos);
  const double wanted = (bytes("few.mkv") + bytes("most.mkv")) / 2;
  EXPECT_EQ(make("middle.mkv", wanted).find("warning"), std::string::npos);
  EXPECT_NEAR(bytes("middle.mkv"), wanted, 0.05 * wanted);
  ASSERT_EQ(run({"motion", clip, "--out", path("m.json")}).code, 0);
  ASSERT_EQ(run({"motion", path("middle.mkv"), "--out", path("n.json")}).code, 0);
  EXPECT_EQ(contents_of(path("m.json")), contents_of(path("n.json")));
}

TEST_F(ClipFiles, CutAndJoinedAgainIsTheSameClip) {
  ASSERT_EQ(run({"cut", path("clip.mkv"), path("a.mkv"), "--frames", ":17"}).code, 0);
  const Said said = run({"cut", path("clip.mkv"), path("b.mkv"), "--frames", "17:", "--json"});
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_EQ(nlohmann::json::parse(said.out)["frames"], 23);
  ASSERT_EQ(run({"join", path("a.mkv"), path("b.mkv"), path("whole.mkv")}).code, 0);
  ASSERT_EQ(run({"motion", path("clip.mkv"), "--out", path("m.json")}).code, 0);
  ASSERT_EQ(run({"motion", path("whole.mkv"), "--out", path("n.json")}).code, 0);
  EXPECT_EQ(contents_of(path("m.json")), contents_of(path("n.json")));
}

TEST_F(ClipFiles, CutReplacesNothingUnlessToldAndWantsARange) {
  folder_.write("a.mkv", "precious");
  expect_error(run({"cut", path("clip.mkv"), path("a.mkv"), "--frames", "0:2"}), 5, "--overwrite");
  expect_error(run({"cut", path("clip.mkv"), path("clip.mkv"), "--frames", "0:2", "--overwrite"}), 5, "clip.mkv");
  EXPECT_EQ(contents_of(path("a.mkv")), "precious");
  expect_error(run({"cut", path("clip.mkv"), path("c.mkv"), "--frames", "0:9:2"}), 2, "A:B");
  expect_error(run({"cut", path("clip.mkv"), path("c.mkv"), "--frames", "90:"}), 2, "--frames");
  EXPECT_FALSE(fs::exists(path("c.mkv")));
}

} // namespace
} // namespace kinora::test
