// kinora encode --live, as a user runs it, follows it and loses it.
#include <nlohmann/json.hpp>

#include "cli/run_kinora.h"
#include "cli/small_disk.h"
#include "clip/clip_io.h"
#include "clip/codec_ids.h"
#include "container/reader.h"
#include "core/random.h"
#include "end_to_end/box_capture.h"

namespace kinora::test {
namespace {

class LiveEncode : public ::testing::Test {
protected:
  LiveEncode() {
    BoxScene scene;
    scene.frames = 30;
    write_box_capture(capture_, scene);
    const std::string intrinsics = contents_of(capture_.path() / "intrinsics.json");
    auto json = nlohmann::json::parse(intrinsics);
    json["fps"] = 6; // five seconds
    capture_.write("intrinsics.json", json.dump());
  }
  std::vector<std::string> words(const std::string& clip) const {
    return {"encode", capture_.path().string(), clip, "--live", "--overwrite"};
  }
  std::string path(const std::string& name) const { return (folder_.path() / name).string(); }

  TemporaryFolder capture_;
  TemporaryFolder folder_;
};

/// Of a live clip that may still grow; 0 where there is none yet.
std::size_t updates_in(const std::string& path) {
  if (!fs::exists(path)) return 0;
  container::Reader reader(path, container::Reading::kFollow);
  if (reader.tag(container::kKindTag) != clip::kLiveClipKind) return 0;
  container::Payload payload;
  std::size_t count = 0;
  while (reader.next(payload)) ++count;
  return count;
}

TEST_F(LiveEncode, CanBeReadWhileItGrowsAndEndsAsAClip) {
  Running running(folder_.path(), words(path("clip.mkv")));
  std::size_t frames = 0;
  std::size_t seen = 0;
  while (!running.ended()) {
    usleep(50'000);
    if (updates_in(path("clip.mkv")) == 0) continue;
    const clip::Clip clip = clip::read_clip(path("clip.mkv"));
    EXPECT_GE(clip.times.size(), frames);
    EXPECT_FALSE(clip.layers.empty());
    frames = clip.times.size();
    ++seen;
  }
  const Said said = running.finish();
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_GE(seen, 1U);
  EXPECT_GE(clip::read_clip(path("clip.mkv")).times.size(), frames);
  EXPECT_EQ(container::Reader(path("clip.mkv")).tag(container::kKindTag), clip::kClipKind);
  EXPECT_EQ(run_kinora(folder_, {"validate", path("clip.mkv")}).code, 0);
}

TEST_F(LiveEncode, IsRefinedForThePictureThatIsAskedFor) {
  std::vector<std::string> asked = words(path("clip.mkv"));
  asked.insert(asked.end(), {"--json", "--preview", path("look.png"), "--every", "0.3"});
  const Said said = run_kinora(folder_, asked);
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_GE(nlohmann::json::parse(said.out).at("live").at("views_refined"), 1);
  EXPECT_TRUE(fs::exists(path("look_0002.png")));
}

/// One encoder that is to be killed once it has written some updates, and a random while after that.
struct Victim {
  std::string file;
  std::size_t updates;        ///< that it may write
  std::uint32_t microseconds; ///< that it may live after that
  std::unique_ptr<Running> running;
};

TEST_F(LiveEncode, KilledAtAnyMomentLosesTheUnfinishedUpdateAtMost) {
  constexpr int kMoments = 50, kAtOnce = 10;
  Random random(33);
  int killed_in_between = 0;
  for (int round = 0; round < kMoments / kAtOnce; ++round) {
    SCOPED_TRACE(round);
    std::vector<Victim> victims;
    for (int v = 0; v < kAtOnce; ++v) {
      const std::string file = path("clip" + std::to_string(v) + ".mkv");
      fs::remove(file);
      victims.push_back({file, random.below(4), random.below(800'000),
                         std::make_unique<Running>(folder_.path(), words(file), path("out" + std::to_string(v)))});
    }
    while (!victims.empty()) {
      usleep(10'000);
      for (auto victim = victims.begin(); victim != victims.end();) {
        if (!victim->running->ended() && updates_in(victim->file) < victim->updates) {
          ++victim;
          continue;
        }
        usleep(victim->microseconds / kAtOnce);
        const bool was_running = !victim->running->ended();
        const std::size_t promised = updates_in(victim->file);
        victim->running->kill_at_once();
        victim->running->finish();
        if (was_running && promised > 0) {
          ++killed_in_between;
          ASSERT_GE(updates_in(victim->file), promised);
          const std::size_t frames = clip::read_clip(victim->file).times.size();
          const std::string saved = path("saved.mkv");
          const Said said = run_kinora(folder_, {"recover", victim->file, saved, "--overwrite"});
          EXPECT_EQ(said.code, 0) << said.err;
          EXPECT_EQ(clip::read_clip(saved).times.size(), frames);
          EXPECT_EQ(container::Reader(saved).tag(container::kKindTag), clip::kClipKind);
        }
        victim = victims.erase(victim);
      }
    }
  }
  EXPECT_GE(killed_in_between, kMoments / 5); // a busy machine writes fewer updates: 23 were seen, 35 on a quiet one
}

TEST_F(LiveEncode, FullDiskLeavesWhatFitted) {
  const Said whole = run_kinora(folder_, words(path("whole.mkv")));
  ASSERT_EQ(whole.code, 0) << whole.err;
  Said said;
  {
    const SmallDisk disk(fs::file_size(path("whole.mkv")) * 5 / 4); // one update, and some of what follows
    said = run_kinora(folder_, words(path("clip.mkv")));
  }
  expect_error(said, 5, "is complete up to there");
  EXPECT_FALSE(clip::read_clip(path("clip.mkv")).layers.empty());
  EXPECT_EQ(run_kinora(folder_, {"validate", path("clip.mkv")}).code, 0);
}

} // namespace
} // namespace kinora::test
