// Preview, poster, chapters and tags at the command line, and in the hands of other programs.
#include <cstdlib>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/run_kinora.h"
#include "clip/clip_edit.h"
#include "clip/clip_io.h"
#include "clip/equal_clips.h"
#include "clip/sample_clip.h"

namespace kinora::test {
namespace {

using Json = nlohmann::json;

constexpr int kFrames = 100; // 3.3 s: two pictures to jump to

class Companions : public testing::Test {
protected:
  Companions() {
    clip::write_clip(clip::testing::bending_clip(1, kFrames, true), path("clip.mkv"));
    folder_.write("chapters.txt", "0.1 Begin\n\n0:01.5  The chair\r\n00:00:02.5 End\n");
  }
  Said run(const std::vector<std::string>& words) const { return run_kinora(folder_, words); }
  std::string path(const std::string& name) const { return (folder_.path() / name).string(); }
  std::string output_of(const std::string& command) const {
    EXPECT_EQ(std::system(fmt::format("{} > {} 2>&1", command, path("said")).c_str()), 0) << contents_of(path("said"));
    return contents_of(path("said"));
  }
  void add_all() const {
    const Said said = run({"cut", path("clip.mkv"), path("all.mkv"), "--flat-preview", "--chapters",
                           path("chapters.txt"), "--tag", "title=Ärger im Haus", "--tag", "COPYRIGHT=CC0"});
    ASSERT_EQ(said.code, 0) << said.err;
  }

  TemporaryFolder folder_;
};

bool is_installed(const char* tool) {
  return std::system(fmt::format("command -v {} > /dev/null 2>&1", tool).c_str()) == 0;
}

TEST_F(Companions, StandBesideTheSameClip) {
  add_all();
  clip::testing::expect_equal(clip::read_clip(path("all.mkv")), clip::read_clip(path("clip.mkv")));
  const Json info = Json::parse(run({"info", path("all.mkv"), "--json"}).out);
  EXPECT_EQ(info["tags"], (Json{{"TITLE", "Ärger im Haus"}, {"COPYRIGHT", "CC0"}}));
  EXPECT_EQ(info["chapters"], Json::parse(R"([{"time_s": 0.1, "title": "Begin"}, {"time_s": 1.5, "title": "The chair"},
                                              {"time_s": 2.5, "title": "End"}])"));
  std::size_t bytes = 0;
  std::size_t of_preview = 0;
  for (const Json& part : info["parts"]) {
    bytes += part["bytes"].get<std::size_t>();
    if (part["name"] == "preview") of_preview = part["bytes"];
  }
  EXPECT_EQ(bytes, fs::file_size(path("all.mkv")));
  EXPECT_GT(of_preview, 1'000U);
  EXPECT_EQ(run({"validate", path("all.mkv")}).code, 0);
  // The same again.
  const std::string first = contents_of(path("all.mkv"));
  fs::remove(path("all.mkv"));
  add_all();
  EXPECT_EQ(contents_of(path("all.mkv")), first);
}

TEST_F(Companions, ArePlayedAndListedByOrdinaryPrograms) {
  if (!is_installed("ffprobe") || !is_installed("mkvinfo")) GTEST_SKIP() << "ffprobe or mkvinfo is not installed";
  add_all();
  const Json probed = Json::parse(output_of(fmt::format(
      "ffprobe -v error -of json -show_streams -show_chapters -show_format -count_frames {}", path("all.mkv"))));
  const Json* film = nullptr;
  const Json* poster = nullptr;
  for (const Json& stream : probed["streams"]) {
    if (stream.value("codec_name", "") == "vp9") film = &stream;
    if (stream.value("codec_name", "") == "mjpeg" && stream["disposition"]["attached_pic"] == 1) poster = &stream;
  }
  ASSERT_NE(film, nullptr) << probed.dump(1);
  ASSERT_NE(poster, nullptr) << probed.dump(1);
  EXPECT_EQ((*film)["nb_read_frames"], std::to_string(kFrames)); // all could be decoded
  ASSERT_EQ(probed["chapters"].size(), 3U);
  EXPECT_EQ(probed["chapters"][1]["tags"]["title"], "The chair");
  EXPECT_EQ(probed["chapters"][1]["start_time"], "1.500000");
  EXPECT_EQ(probed["format"]["tags"]["COPYRIGHT"], "CC0");
  const std::string listed = output_of("LC_ALL=C.UTF-8 mkvinfo " + path("all.mkv"));
  for (const char* what : {"V_VP9", "The chair", "cover.jpg", "Ärger im Haus"})
    EXPECT_NE(listed.find(what), std::string::npos) << what << " is not in\n" << listed;
  if (!is_installed("ffplay")) return;
  const std::string played = output_of(fmt::format(
      "SDL_VIDEODRIVER=dummy SDL_AUDIODRIVER=dummy timeout 60 ffplay -v error -autoexit -loop 1 {}", path("all.mkv")));
  EXPECT_EQ(played.find_first_not_of(" \r\n"), std::string::npos) << played;
}

TEST_F(Companions, AreKeptByCutJoinRecoverAndMkvmerge) {
  add_all();
  ASSERT_EQ(run({"cut", path("all.mkv"), path("a.mkv"), "--frames", ":55"}).code, 0);
  ASSERT_EQ(run({"cut", path("all.mkv"), path("b.mkv"), "--frames", "55:"}).code, 0);
  const clip::StoredClip whole = clip::load_stored_clip(path("all.mkv"));
  const clip::StoredClip second = clip::load_stored_clip(path("b.mkv"));
  ASSERT_TRUE(whole.preview && second.preview);
  EXPECT_EQ(whole.preview->packets.size(), static_cast<std::size_t>(kFrames));
  EXPECT_EQ(second.chapters.size(), 2U); // the chair's goes on where the second piece begins
  EXPECT_EQ(second.chapters[0].time_ns, second.description.times_ns[0]);
  EXPECT_TRUE(second.preview->packets[0].key);
  const std::int64_t late = second.preview->packets[0].time_ns - second.description.times_ns[0];
  EXPECT_LT(late, 2'000'000'000); // to where players can jump
  EXPECT_EQ(second.poster->bytes, whole.poster->bytes);
  ASSERT_EQ(run({"join", path("a.mkv"), path("b.mkv"), path("joined.mkv")}).code, 0);
  const clip::StoredClip joined = clip::load_stored_clip(path("joined.mkv"));
  EXPECT_EQ(joined.chapters, whole.chapters);
  EXPECT_EQ(joined.tags, whole.tags);
  ASSERT_TRUE(joined.preview);
  EXPECT_EQ(joined.preview->packets.size(), 55 + second.preview->packets.size());

  ASSERT_EQ(run({"recover", path("all.mkv"), path("recovered.mkv")}).code, 0);
  EXPECT_EQ(clip::load_stored_clip(path("recovered.mkv")).chapters, whole.chapters);
  if (!is_installed("mkvmerge")) return;
  output_of(fmt::format("mkvmerge -o {} {}", path("remuxed.mkv"), path("all.mkv")));
  clip::testing::expect_equal(clip::read_clip(path("remuxed.mkv")), clip::read_clip(path("clip.mkv")));
  const clip::StoredClip remuxed = clip::load_stored_clip(path("remuxed.mkv"));
  EXPECT_EQ(remuxed.chapters, whole.chapters);
  ASSERT_TRUE(remuxed.preview && remuxed.poster);
  EXPECT_EQ(remuxed.preview->packets.size(), static_cast<std::size_t>(kFrames));
}

TEST_F(Companions, TagsAreReplacedAndRemoved) {
  add_all();
  const Said said = run({"cut", path("all.mkv"), path("b.mkv"), "--tag", "COPYRIGHT=", "--tag", "TITLE=Two"});
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_EQ(Json::parse(run({"info", path("b.mkv"), "--json"}).out)["tags"], (Json{{"TITLE", "Two"}}));
}

TEST_F(Companions, WhatIsNoChapterOrTagIsNamed) {
  const auto cut = [this](const std::vector<std::string>& words) {
    std::vector<std::string> all{"cut", path("clip.mkv"), path("o.mkv")};
    all.insert(all.end(), words.begin(), words.end());
    return run(all);
  };
  expect_error(cut({}), 2, "nothing to do");
  expect_error(cut({"--tag", "TITLE"}), 2, "NAME=VALUE");
  expect_error(cut({"--tag", "KINORA_KIND=clip"}), 2, "Kinora's own");
  expect_error(cut({"--chapters", path("none.txt")}), 2, "none.txt");
  for (const auto& [text, why] : {std::pair("0 One\nTwo\n", "line 2"), std::pair("1:2:3:4 One\n", "line 1"),
                                  std::pair("2 One\n1 Two\n", "line 2"), std::pair("\n", "no chapter")}) {
    folder_.write("bad.txt", text);
    expect_error(cut({"--chapters", path("bad.txt")}), 4, why);
  }
  EXPECT_FALSE(fs::exists(path("o.mkv")));
  folder_.write("late.txt", "0 One\n1:00 Two\n");
  const Said late = cut({"--chapters", path("late.txt")});
  EXPECT_EQ(late.code, 0);
  EXPECT_NE(late.err.find("\"Two\" would begin behind the last frame"), std::string::npos) << late.err;
}

} // namespace
} // namespace kinora::test
