#include "player/clip_feed.h"

#include <chrono>
#include <condition_variable>
#include <cstring>
#include <fstream>

#include <gtest/gtest.h>

#include "clip/clip_io.h"
#include "clip/live_clip_writer.h"
#include "clip/sample_clip.h"
#include "core/error.h"
#include "player/window/viewer.h"

namespace kinora::player {
namespace {

/// Bytes that come when the test lets them.
class SlowSource final : public container::ByteSource {
public:
  struct Shared {
    std::mutex mutex;
    std::condition_variable changed;
    std::vector<std::byte> bytes;
    std::size_t size = 0;           ///< that is told
    std::size_t allowed = 0;        ///< that may be read
    container::ByteRange held_back; ///< but for these
    std::string fault;              ///< of what is read beyond
    double now = 0;
  };
  explicit SlowSource(std::shared_ptr<Shared> shared) : shared_(std::move(shared)), size_(shared_->size) {}

  const std::string& name() const override { return name_; }
  std::uint64_t size() const override { return size_; }
  void read(std::uint64_t offset, std::span<std::byte> out) override {
    std::unique_lock lock(shared_->mutex);
    const auto is_allowed = [&] {
      const auto [begin, end] = shared_->held_back;
      return offset + out.size() <= shared_->allowed && (offset >= end || offset + out.size() <= begin);
    };
    shared_->changed.wait(lock, [&] { return is_allowed() || !shared_->fault.empty(); });
    if (!is_allowed()) throw Error(ErrorCode::kFailure, shared_->fault);
    std::memcpy(out.data(), shared_->bytes.data() + offset, out.size());
    shared_->now += 1; // each piece has been waited for
  }
  bool may_grow() const override { return true; }
  void refresh() override {
    const std::lock_guard lock(shared_->mutex);
    size_ = shared_->size;
  }

private:
  std::string name_ = "slow.mkv";
  std::shared_ptr<Shared> shared_;
  std::uint64_t size_;
};

bool never() { return false; }

class ClipFeedTest : public ::testing::Test {
protected:
  ClipFeedTest() {
    const auto path =
        std::filesystem::path(::testing::TempDir()) / ::testing::UnitTest::GetInstance()->current_test_info()->name();
    fields::FieldConfig large = clip::testing::small_config();
    large.log2_table_size = 18;
    large.finest_resolution = 1024;
    clip::Clip clip = clip::testing::sample_clip(1, 40, true);
    for (clip::Layer& layer : clip.layers) {
      layer.field = clip::testing::random_field(2, large);
      layer.confidence.reset();
    }
    clip::write_clip(clip, path);
    std::ifstream file(path, std::ios::binary);
    const std::string text((std::istreambuf_iterator<char>(file)), {});
    shared_->bytes.resize(text.size());
    std::memcpy(shared_->bytes.data(), text.data(), text.size());
    shared_->size = text.size();
    EXPECT_GT(text.size(), std::size_t{2} << 17) << "it is not read in pieces";
    std::filesystem::remove(path);
  }

  void allow(std::size_t bytes) {
    const std::lock_guard lock(shared_->mutex);
    shared_->allowed = bytes;
    shared_->changed.notify_all();
  }
  void fail_with(const std::string& fault) {
    const std::lock_guard lock(shared_->mutex);
    shared_->fault = fault;
    shared_->changed.notify_all();
  }
  std::unique_ptr<ClipFeed> feed() {
    return std::make_unique<ClipFeed>(std::make_unique<SlowSource>(shared_), [shared = shared_] {
      const std::lock_guard lock(shared->mutex);
      return shared->now;
    });
  }
  /// Once `is_there` holds of it.
  template <class IsThere> static ClipSoFar wait_for(const ClipFeed& feed, const IsThere& is_there) {
    for (;;) {
      ClipSoFar now = feed.newest();
      if (is_there(now)) return now;
      std::this_thread::yield();
    }
  }

  std::shared_ptr<SlowSource::Shared> shared_ = std::make_shared<SlowSource::Shared>();
};

TEST_F(ClipFeedTest, ShowsLayersBeforeTheFileIsWhole) {
  const auto feed = this->feed();
  const std::size_t bytes = shared_->bytes.size();
  allow(bytes - 1); // all pieces but the last
  const ClipSoFar first = feed->first(never);
  EXPECT_FALSE(first.complete);
  EXPECT_GE(first.player->clip().layers.size(), 1U);
  EXPECT_NE(first.message.find("% has come"), std::string::npos) << first.message;
  allow(bytes);
  const ClipSoFar all = wait_for(*feed, [](const ClipSoFar& now) { return now.complete; });
  EXPECT_EQ(all.player->clip().layers.size(), clip::testing::sample_clip(1, 40, true).layers.size());
  EXPECT_EQ(all.player->frame_count(), 40U);
  EXPECT_EQ(all.message, "");
}

TEST_F(ClipFeedTest, GivesAFirstLookOnceAllLayersHaveComeAndThenTheWhole) {
  const auto feed =
      std::make_unique<ClipFeed>(std::make_unique<SlowSource>(shared_), [] { return 0.0; }); // no patience
  const std::size_t bytes = shared_->bytes.size();
  allow(bytes - 1);
  const ClipSoFar first = feed->first(never);
  EXPECT_EQ(first.player->readiness(), Readiness::kFirstLook);
  EXPECT_EQ(first.player->clip().layers.size(), clip::testing::sample_clip(1, 40, true).layers.size());
  allow(bytes);
  const ClipSoFar all = wait_for(*feed, [](const ClipSoFar& now) { return now.complete; });
  EXPECT_EQ(all.player->readiness(), Readiness::kWhole);
  const Player whole(clip::read_clip(std::make_unique<container::MemorySource>(shared_->bytes, "memory.mkv")));
  Camera camera = whole.clip().capture_camera(39);
  camera.intrinsics = camera.intrinsics.resized(64, 48);
  const auto drawn = [&](const Player& player) {
    const ColorImage image = player.draw(camera, 39, player.all_layers()).color;
    return std::vector<std::uint8_t>(image.values().begin(), image.values().end());
  };
  EXPECT_EQ(drawn(*all.player), drawn(whole));
}

TEST_F(ClipFeedTest, MakesReadyWhatCameBeforeTheSourceFailed) {
  const auto feed = std::make_unique<ClipFeed>(std::make_unique<SlowSource>(shared_), [] { return 0.0; });
  allow(shared_->bytes.size() - 1);
  EXPECT_EQ(feed->first(never).player->readiness(), Readiness::kFirstLook);
  fail_with("the server is gone");
  const ClipSoFar last = wait_for(*feed, [](const ClipSoFar& now) { return now.complete; });
  EXPECT_EQ(last.player->readiness(), Readiness::kWhole);
  EXPECT_EQ(last.message, "the server is gone");
}

TEST_F(ClipFeedTest, KeepsWhatItShowsWhenTheSourceFails) {
  const auto feed = this->feed();
  allow(shared_->bytes.size() - 1);
  const auto shown = feed->first(never).player;
  fail_with("the server is gone");
  const ClipSoFar last = wait_for(*feed, [](const ClipSoFar& now) { return now.complete; });
  EXPECT_NE(last.player, nullptr);
  EXPECT_EQ(last.message, "the server is gone");
}

/// Much is to come before anything moves, and a piece in the middle of what moves does not come.
class SoughtClipFeed : public ::testing::Test {
protected:
  static constexpr int kFrames = 400;

  SoughtClipFeed() {
    const auto path =
        std::filesystem::path(::testing::TempDir()) / ::testing::UnitTest::GetInstance()->current_test_info()->name();
    clip::Clip clip = clip::testing::sample_clip(1, kFrames, true);
    fields::FieldConfig large = clip::testing::small_config();
    large.log2_table_size = 18;
    large.finest_resolution = 1024;
    clip.layers.front().field = clip::testing::random_field(2, large);
    clip.layers.front().confidence.reset();
    clip::write_clip(clip, path);
    std::ifstream file(path, std::ios::binary);
    const std::string text((std::istreambuf_iterator<char>(file)), {});
    std::filesystem::remove(path);
    const auto bytes = std::as_bytes(std::span(text));
    shared_->bytes.assign(bytes.begin(), bytes.end());
    shared_->size = shared_->allowed = text.size();
    times_ = clip.times;
    container::MemorySource whole(bytes, "sought.mkv");
    const auto index = container::CueIndex::read(bytes.first(4096), whole);
    EXPECT_TRUE(index);
    if (!index) return;
    shared_->held_back = index->bytes_for(times_[kFrames / 2]);
    EXPECT_GT(shared_->held_back.begin, std::size_t{2} << 17);
    EXPECT_LE(shared_->held_back.end, index->bytes_for(times_.back()).begin);
  }

  std::unique_ptr<ClipFeed> feed() {
    return std::make_unique<ClipFeed>(std::make_unique<SlowSource>(shared_), [] { return 0.0; }); // no patience
  }
  void allow(std::size_t bytes) {
    const std::lock_guard lock(shared_->mutex);
    shared_->allowed = bytes;
    shared_->changed.notify_all();
  }
  /// Whether it is so within a minute.
  template <class IsSo> static bool soon(const IsSo& is_so) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
    while (!is_so()) {
      if (std::chrono::steady_clock::now() > end) return false;
      std::this_thread::yield();
    }
    return true;
  }
  void let_all_come() {
    const std::lock_guard lock(shared_->mutex);
    shared_->held_back = {};
    shared_->changed.notify_all();
  }

  std::shared_ptr<SlowSource::Shared> shared_ = std::make_shared<SlowSource::Shared>();
  std::vector<double> times_;
};

TEST_F(SoughtClipFeed, HasWhatIsSoughtBeforeWhatLiesBetween) {
  const auto feed = this->feed();
  feed->seek(times_.back());
  ClipSoFar now;
  const bool came = soon([&] {
    now = feed->newest();
    return now.there.size() == kFrames && now.there.back();
  });
  if (!came) let_all_come();
  ASSERT_TRUE(came);
  EXPECT_FALSE(now.complete);
  EXPECT_FALSE(now.there[kFrames / 2]);
  EXPECT_EQ(now.times, now.player->clip().times);
  EXPECT_EQ(now.player->frame_count(), std::size_t{kFrames});
  let_all_come();
  ASSERT_TRUE(soon([&] { return (now = feed->newest()).complete; }));
  EXPECT_EQ(now.message, "");
  EXPECT_TRUE(std::ranges::all_of(now.there, [](bool there) { return there; }));
}

TEST_F(SoughtClipFeed, AWindowPlaysOnWhereItWasSetAndKeepsItsPictureUntilThen) {
  // What the feed waits for when something is sought comes before that is asked for.
  constexpr int kPieceBits = 17;
  const std::size_t all = shared_->allowed;
  shared_->allowed = ((shared_->held_back.begin >> kPieceBits) - 1) << kPieceBits;
  double seconds = 0;
  window::Viewer viewer(
      "some.mkv", [this](const std::string&) { return feed(); }, ::testing::TempDir(), [] { return false; },
      [&] { return seconds; });
  const auto panel = [&] { return viewer.panel(40, 30); };
  EXPECT_EQ(panel().frame_count, std::size_t{kFrames}) << "what has not come can be sought";
  viewer.act({window::Action::Kind::kSeek, times_[kFrames - 10]});
  viewer.act({window::Action::Kind::kPlayPause}); // it begins by itself otherwise
  viewer.act({window::Action::Kind::kPlayPause});
  EXPECT_EQ(panel().frame, std::size_t{kFrames - 10});
  allow(all);
  const bool played = soon([&] {
    seconds += 0.01;
    return panel().frame == kFrames - 1;
  });
  if (!played) let_all_come();
  ASSERT_TRUE(played);
  EXPECT_TRUE(panel().playing) << "it waits for what has been passed over";
  viewer.act({window::Action::Kind::kSeek, times_[kFrames / 2]});
  seconds += 100;
  EXPECT_EQ(panel().frame, std::size_t{kFrames / 2}) << "nothing of it has come";
  let_all_come();
  EXPECT_TRUE(soon([&] {
    seconds += 0.01;
    return panel().frame != kFrames / 2;
  }));
}

TEST_F(ClipFeedTest, SaysWhyThereIsNothingToShow) {
  fail_with("the server is gone");
  EXPECT_THROW(feed()->first(never), Error);
  shared_->fault = "";
  std::fill(shared_->bytes.begin(), shared_->bytes.end(), std::byte{7});
  allow(shared_->bytes.size());
  EXPECT_THROW(feed()->first(never), Error);
}

TEST_F(ClipFeedTest, FollowsAFileThatGrows) {
  const std::size_t bytes = shared_->bytes.size();
  shared_->size = bytes * 7 / 8;
  allow(bytes);
  const auto feed = this->feed();
  const ClipSoFar early = wait_for(*feed, [](const ClipSoFar& now) { return now.player && !now.message.empty(); });
  EXPECT_FALSE(early.complete);
  {
    const std::lock_guard lock(shared_->mutex);
    shared_->size = bytes;
  }
  const ClipSoFar all = wait_for(*feed, [](const ClipSoFar& now) { return now.complete; });
  EXPECT_EQ(all.player->frame_count(), 40U);
}

TEST(LiveClipFeed, FollowsWhatAnEncoderWrites) {
  const auto path = std::filesystem::path(::testing::TempDir()) / "live_clip_feed.mkv";
  const clip::Clip later = clip::testing::sample_clip(3, 9, false);
  clip::Clip early = clip::testing::sample_clip(3, 4, false);
  clip::LiveClipWriter writer(path, early.intrinsics);
  writer.write(early);
  const ClipFeed feed(std::make_unique<container::FileSource>(path));
  const ClipSoFar first = feed.first(never);
  EXPECT_FALSE(first.complete);
  EXPECT_EQ(first.player->frame_count(), 4U);
  writer.write(later);
  ClipSoFar now;
  do now = feed.newest();
  while (now.player->frame_count() == 4U);
  EXPECT_EQ(now.player->frame_count(), 9U);
  writer.finish();
  do now = feed.newest();
  while (!now.complete);
  EXPECT_EQ(now.player->frame_count(), 9U);
  std::filesystem::remove(path);
}

TEST_F(ClipFeedTest, EndsAtOnceWhileItWaits) {
  shared_->size = shared_->bytes.size() / 2;
  allow(shared_->bytes.size());
  const auto feed = this->feed();
  EXPECT_THROW(feed->first([] { return true; }), Error);
}

} // namespace
} // namespace kinora::player
