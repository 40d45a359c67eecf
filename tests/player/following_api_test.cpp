#include <kinora/player.h>
#include <kinora/player.hpp>

#include <algorithm>
#include <condition_variable>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <thread>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "clip/clip_io.h"
#include "clip/sample_clip.h"

namespace kinora {
namespace {
namespace fs = std::filesystem;

constexpr std::size_t kFrames = 40;

/// A clip that is read in several pieces.
std::vector<std::byte> written_clip() {
  const fs::path path = fs::path(::testing::TempDir()) / fmt::format("following_{}.mkv", getpid());
  fields::FieldConfig large = clip::testing::small_config();
  large.log2_table_size = 18;
  large.finest_resolution = 1024;
  clip::Clip clip = clip::testing::sample_clip(1, kFrames, true);
  for (clip::Layer& layer : clip.layers) {
    layer.field = clip::testing::random_field(2, large);
    layer.confidence.reset();
  }
  clip::write_clip(clip, path);
  std::ifstream file(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  fs::remove(path);
  std::vector<std::byte> bytes(text.size());
  std::memcpy(bytes.data(), text.data(), text.size());
  return bytes;
}

const std::vector<std::byte>& clip_bytes() {
  static const std::vector<std::byte> bytes = written_clip();
  return bytes;
}

/// Gives no more than it is allowed to; a reader of more waits, or fails.
class Arriving final : public ClipSource {
public:
  explicit Arriving(std::vector<std::byte> all, bool all_is_known = true)
      : bytes(std::move(all)), known_(all_is_known ? bytes.size() : 0), grows_(!all_is_known) {}

  std::string name() const override { return "arriving.mkv"; }
  std::uint64_t size() const override {
    const std::lock_guard lock(mutex_);
    return known_;
  }
  bool grows() const noexcept override { return grows_; }
  bool read(std::uint64_t offset, std::span<std::byte> out) noexcept override {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return broken_ || offset + out.size() <= allowed_; });
    if (offset + out.size() > allowed_) return false;
    std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(offset), out.size(), out.begin());
    return true;
  }
  void allow(std::size_t count) {
    const std::lock_guard lock(mutex_);
    allowed_ = count;
    if (grows_) known_ = count;
    changed_.notify_all();
  }
  void break_off() {
    const std::lock_guard lock(mutex_);
    broken_ = true;
    changed_.notify_all();
  }

  const std::vector<std::byte> bytes;

private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t known_, allowed_ = 0;
  bool grows_, broken_ = false;
};

ClipArrival all_of(ClipPlayer& clip) {
  ClipArrival arrival;
  for (; !arrival.complete; std::this_thread::yield()) arrival = clip.update();
  return arrival;
}

std::vector<std::uint8_t> picture_of(const ClipPlayer& clip) {
  KinoraPlayerCamera camera = clip.capture_camera(0);
  EXPECT_EQ(kinora_player_resize_camera(&camera, 40, 30), KINORA_PLAYER_OK);
  return clip.render(camera, clip.frame_time(0)).color;
}

TEST(Following, AWholeClipIsTheClip) {
  Arriving source(clip_bytes());
  source.allow(source.bytes.size());
  ClipPlayer followed = ClipPlayer::follow(source);
  EXPECT_EQ(all_of(followed).message, "");
  const ClipPlayer opened = ClipPlayer::open(source);
  EXPECT_EQ(followed.info().frames, kFrames);
  EXPECT_EQ(followed.info().bytes, source.bytes.size());
  EXPECT_EQ(picture_of(followed), picture_of(opened));
}

TEST(Following, ADamagedClipIsShownAsFarAsItIsWholeAndSaysWhatIsMissing) {
  std::vector<std::byte> bytes = clip_bytes();
  bytes.resize(bytes.size() * 7 / 8);
  Arriving source(std::move(bytes));
  source.allow(source.bytes.size());
  EXPECT_THROW(ClipPlayer::open(source), ClipError);
  ClipPlayer clip = ClipPlayer::follow(source);
  EXPECT_NE(all_of(clip).message.find("missing"), std::string::npos);
  EXPECT_GE(clip.info().layers, 1U);
  EXPECT_FALSE(picture_of(clip).empty());
}

TEST(Following, AClipThatIsStillBeingWrittenBecomesWhole) {
  Arriving source(clip_bytes(), false);
  source.allow(source.bytes.size() * 7 / 8);
  ClipPlayer clip = ClipPlayer::follow(source);
  EXPECT_FALSE(clip.update().complete);
  clip.play();
  const std::string first = clip.layers().front().name;
  const KinoraPlayerLayer known = clip.layers().front();
  source.allow(source.bytes.size());
  EXPECT_EQ(all_of(clip).message, "");
  EXPECT_EQ(known.name, first) << "a layer's name does not live as long as the player";
  EXPECT_EQ(picture_of(clip), picture_of(ClipPlayer::open(source)));
}

TEST(Following, NothingChangesButByAnUpdate) {
  Arriving source(clip_bytes(), false);
  source.allow(source.bytes.size() * 7 / 8);
  ClipPlayer clip = ClipPlayer::follow(source);
  ClipPlayer beside = ClipPlayer::follow(source);
  const std::uint64_t bytes = clip.info().bytes;
  source.allow(source.bytes.size());
  all_of(beside);
  EXPECT_EQ(clip.info().bytes, bytes);
}

TEST(Following, WhatHasComeStaysWhenTheSourceBreaksOff) {
  Arriving source(clip_bytes(), false);
  source.allow(source.bytes.size() * 7 / 8);
  ClipPlayer clip = ClipPlayer::follow(source);
  while (clip.update().message.find("this is all so far") == std::string::npos) std::this_thread::yield();
  const auto picture = picture_of(clip); // not of a first look
  source.allow(1);                       // shorter than it was
  const ClipArrival last = all_of(clip);
  EXPECT_NE(last.message.find("arriving.mkv"), std::string::npos) << last.message;
  EXPECT_EQ(picture_of(clip), picture);
}

TEST(Following, WhatNeverShowsAnythingIsAnError) {
  Arriving source(clip_bytes());
  source.break_off();
  try {
    ClipPlayer::follow(source);
    FAIL() << "it was opened";
  } catch (const ClipError& error) {
    EXPECT_EQ(error.status(), KINORA_PLAYER_FAILURE);
    EXPECT_NE(std::string(error.what()).find("arriving.mkv: bytes 0 to"), std::string::npos) << error.what();
  }
  EXPECT_THROW(ClipPlayer::follow("/none/clip.mkv"), ClipError);
}

TEST(Following, AClipThatWasOpenedWholeIsComplete) {
  Arriving source(clip_bytes());
  source.allow(source.bytes.size());
  ClipPlayer clip = ClipPlayer::open(source);
  const ClipArrival arrival = clip.update();
  EXPECT_TRUE(arrival.complete);
  EXPECT_FALSE(arrival.more);
  EXPECT_EQ(arrival.message, "");
}

} // namespace
} // namespace kinora
