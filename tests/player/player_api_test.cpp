#include <kinora/player.h>
#include <kinora/player.hpp>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <limits>
#include <thread>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "clip/clip_io.h"
#include "clip/sample_clip.h"
#include "fields/scenes/painted_field.h"
#include "player/picture_view.h"
#include "player/player.h"

namespace kinora {
namespace {
namespace fs = std::filesystem;

constexpr int kWidth = 40;
constexpr int kHeight = 30;

class PlayerApi : public ::testing::Test {
protected:
  static void SetUpTestSuite() {
    path() = fs::path(::testing::TempDir()) / fmt::format("player_api_{}.mkv", getpid());
    clip::write_clip(two_balls(), path());
  }
  /// One that stands, and one beside it that moves away; small, because every test draws them.
  static clip::Clip two_balls() {
    clip::Clip clip = clip::testing::sample_clip(5, 4, false);
    clip.camera_to_world = {SE3(Eigen::Translation3d(0, 0, -1.5))};
    clip.layers[0].field =
        fields::testing::painted_field({{-0.5, -0.5, -0.5}, 1}, fields::testing::PaintedBall{{-0.2, 0, 0}, 0.1});
    clip.layers[0].confidence = clip::testing::random_confidence(clip.layers[0].field.occupancy, 3);
    clip.layers[1].field =
        fields::testing::painted_field({{-0.5, -0.5, -0.5}, 1}, fields::testing::PaintedBall{{0.2, 0, 0}, 0.1});
    std::vector<motion::Motion::Pose> poses;
    poses.reserve(4);
    for (int i = 0; i < 4; ++i) poses.push_back({SE3(Eigen::Translation3d(0.1 * i, 0, 0))});
    clip.layers[1].motion = motion::Motion::rigid(std::move(poses));
    return clip;
  }
  static void TearDownTestSuite() { fs::remove(path()); }
  static fs::path& path() {
    static fs::path kept;
    return kept;
  }
  static std::vector<std::byte> bytes() {
    std::ifstream file(path(), std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    const auto* first = reinterpret_cast<const std::byte*>(text.data());
    return {first, first + text.size()};
  }
  static KinoraPlayerCamera small_camera(const ClipPlayer& clip) {
    KinoraPlayerCamera camera = clip.capture_camera(0);
    EXPECT_EQ(kinora_player_resize_camera(&camera, kWidth, kHeight), KINORA_PLAYER_OK);
    return camera;
  }
  static std::vector<std::uint8_t> expected(std::size_t frame, const player::LayerChoice& layers,
                                            player::PictureView view) {
    const player::Player player(clip::read_clip(path()));
    Camera camera = player.clip().capture_camera(0);
    camera.intrinsics = camera.intrinsics.resized(kWidth, kHeight);
    const auto at = static_cast<double>(frame);
    const ColorImage image = player::painted(player.draw(camera, at, layers, player::draw_options_for(view)), view,
                                             player.drawn_health(at, layers));
    return {image.values().begin(), image.values().end()};
  }
};

struct SomeBytes final : ClipSource {
  std::vector<std::byte> bytes;
  bool fails = false;
  std::string name() const override { return "some bytes"; }
  std::uint64_t size() const override { return bytes.size(); }
  bool read(std::uint64_t offset, std::span<std::byte> out) noexcept override {
    if (fails || offset + out.size() > bytes.size()) return false;
    std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(offset), out.size(), out.begin());
    return true;
  }
};

TEST_F(PlayerApi, SaysWhatTheClipHolds) {
  const ClipPlayer clip = ClipPlayer::open(path());
  const clip::Clip known = clip::read_clip(path());
  EXPECT_EQ(clip.info().frames, known.times.size());
  EXPECT_EQ(clip.info().bytes, fs::file_size(path()));
  EXPECT_EQ(clip.info().width, known.intrinsics.width);
  ASSERT_EQ(clip.layers().size(), known.layers.size());
  for (std::size_t i = 0; i < known.layers.size(); ++i) {
    EXPECT_EQ(clip.layers()[i].name, known.layers[i].name);
    EXPECT_EQ(clip.layers()[i].motion, motion::name_of(known.layers[i].motion.kind()));
  }
  EXPECT_EQ(clip.frame_time(2), known.times[2]);
  EXPECT_THROW(clip.frame_time(known.times.size()), ClipError);
}

TEST_F(PlayerApi, DrawsThePictureOfThePlayerOutOfFilesMemoryAndCallbacks) {
  SomeBytes source;
  source.bytes = bytes();
  const auto wanted = expected(2, {0, 1}, player::PictureView::kColor);
  const std::vector<std::byte> memory = bytes();
  for (const ClipPlayer& clip :
       {ClipPlayer::open(path()), ClipPlayer::open(memory, "memory"), ClipPlayer::open(source)}) {
    EXPECT_EQ(clip.render(small_camera(clip), clip.frame_time(2)).color, wanted);
  }
}

TEST_F(PlayerApi, HiddenLayersAreNotDrawn) {
  const ClipPlayer clip = ClipPlayer::open(path());
  ASSERT_EQ(clip.info().layers, 2);
  ClipPicture picture{kWidth, kHeight, std::vector<std::uint8_t>(4 * kWidth * kHeight)};
  const std::array<std::uint8_t, 2> visible{0, 1};
  const KinoraPlayerRequest request{
      sizeof request, small_camera(clip), clip.frame_time(2), visible.data(), nullptr, nullptr, 0};
  const KinoraPlayerPicture buffers{sizeof buffers, KINORA_PLAYER_COLOR, picture.color.data(), 0, nullptr, nullptr,
                                    nullptr};
  ASSERT_EQ(kinora_player_render(clip.get(), &request, &buffers), KINORA_PLAYER_OK) << kinora_player_error();
  EXPECT_EQ(picture.color, expected(2, {1}, player::PictureView::kColor));
  EXPECT_NE(picture.color, expected(2, {0, 1}, player::PictureView::kColor));
}

TEST_F(PlayerApi, ViewsShowDepthNormalsConfidenceAndHealth) {
  const ClipPlayer clip = ClipPlayer::open(path());
  const auto colors = expected(1, {0, 1}, player::PictureView::kColor);
  for (const auto view : {KINORA_PLAYER_DEPTH, KINORA_PLAYER_NORMAL, KINORA_PLAYER_CONFIDENCE, KINORA_PLAYER_HEALTH}) {
    const auto drawn = clip.render(small_camera(clip), clip.frame_time(1), view).color;
    EXPECT_EQ(drawn, expected(1, {0, 1}, static_cast<player::PictureView>(view)));
    EXPECT_NE(drawn, colors);
  }
  EXPECT_THROW(clip.render(small_camera(clip), 0, 9), ClipError);
}

TEST_F(PlayerApi, RowsOfTheCallersBufferMayHaveGapsThatAreNotWritten) {
  const ClipPlayer clip = ClipPlayer::open(path());
  constexpr std::size_t kRow = 4 * kWidth + 12;
  std::vector<std::uint8_t> color(kRow * kHeight, 77);
  std::vector<float> depth(kWidth * kHeight, -1);
  const KinoraPlayerRequest request{sizeof request, small_camera(clip), 0, nullptr, nullptr, nullptr, 0};
  KinoraPlayerPicture buffers{sizeof buffers, KINORA_PLAYER_COLOR, color.data(), kRow, depth.data(), nullptr, nullptr};
  ASSERT_EQ(kinora_player_render(clip.get(), &request, &buffers), KINORA_PLAYER_OK) << kinora_player_error();
  const auto wanted = expected(0, {0, 1}, player::PictureView::kColor);
  for (std::size_t v = 0; v < kHeight; ++v) {
    EXPECT_TRUE(std::equal(&color[v * kRow], &color[v * kRow] + 4 * kWidth, &wanted[v * 4 * kWidth]));
    EXPECT_TRUE(std::all_of(&color[v * kRow] + 4 * kWidth, &color[v * kRow] + kRow, [](auto x) { return x == 77; }));
  }
  EXPECT_TRUE(std::all_of(depth.begin(), depth.end(), [](float z) { return z >= 0; }));
  buffers.color_row_bytes = 4 * kWidth - 1;
  EXPECT_EQ(kinora_player_render(clip.get(), &request, &buffers), KINORA_PLAYER_USAGE);
}

TEST_F(PlayerApi, CoarsePicturesComeFirstAndTheLastIsTheFullOne) {
  const ClipPlayer clip = ClipPlayer::open(path());
  std::vector<ClipPicture> seen;
  std::vector<bool> finest;
  const auto refined = [&](const ClipPicture& picture, bool last) {
    seen.push_back(picture);
    finest.push_back(last);
    return true;
  };
  const ClipPicture full = clip.render(small_camera(clip), clip.frame_time(2), KINORA_PLAYER_COLOR, refined);
  EXPECT_EQ(finest, (std::vector{false, false, false, true}));
  EXPECT_EQ(full.color, expected(2, {0, 1}, player::PictureView::kColor));
  EXPECT_EQ(full.color, seen.back().color);
  const auto opaque = [](const ClipPicture& picture) {
    int count = 0;
    for (std::size_t i = 3; i < picture.color.size(); i += 4) count += picture.color[i] > 127 ? 1 : 0;
    return count;
  };
  for (const ClipPicture& coarse : seen) EXPECT_NEAR(opaque(coarse), opaque(full), kWidth * kHeight / 8.0);
}

TEST_F(PlayerApi, APreviewHasOneSampleToAPixelAndRequestsOfTheFirstVersionDrawTheFullPicture) {
  const ClipPlayer clip = ClipPlayer::open(path().string());
  KinoraPlayerRequest request{};
  request.struct_size = sizeof request;
  request.camera = small_camera(clip);
  request.preview = 1;
  std::vector<std::uint8_t> color(4 * kWidth * kHeight);
  KinoraPlayerPicture picture{};
  picture.struct_size = sizeof picture;
  picture.color = color.data();
  ASSERT_EQ(kinora_player_render(clip.get(), &request, &picture), KINORA_PLAYER_OK) << kinora_player_error();
  const std::vector<std::uint8_t> preview = color;
  request.struct_size = offsetof(KinoraPlayerRequest, preview);
  ASSERT_EQ(kinora_player_render(clip.get(), &request, &picture), KINORA_PLAYER_OK) << kinora_player_error();
  EXPECT_EQ(color, clip.render(request.camera, 0).color);
  EXPECT_NE(preview, color);
}

TEST_F(PlayerApi, SaysWhatACameraTurnsAround) {
  const ClipPlayer clip = ClipPlayer::open(path().string());
  std::array<double, 3> first{};
  std::array<double, 3> last{};
  ASSERT_EQ(kinora_player_subject(clip.get(), 0, first.data()), KINORA_PLAYER_OK) << kinora_player_error();
  ASSERT_EQ(kinora_player_subject(clip.get(), clip.frame_time(3), last.data()), KINORA_PLAYER_OK);
  EXPECT_NEAR(first[0], 0.2, 0.05); // the middle of the ball that moves
  EXPECT_NEAR(last[0] - first[0], 0.3, 1e-6);
}

TEST_F(PlayerApi, StopsWhereTheCallbackSaysSoAndKeepsThatPicture) {
  const ClipPlayer clip = ClipPlayer::open(path());
  int calls = 0;
  ClipPicture coarse;
  const auto refined = [&](const ClipPicture& picture, bool) {
    coarse = picture;
    return ++calls < 2;
  };
  const ClipPicture kept = clip.render(small_camera(clip), 0, KINORA_PLAYER_COLOR, refined);
  EXPECT_EQ(calls, 2);
  EXPECT_EQ(kept.color, coarse.color);
  EXPECT_THROW(clip.render(small_camera(clip), 0, KINORA_PLAYER_COLOR,
                           [](const ClipPicture&, bool) -> bool { throw std::runtime_error("mine"); }),
               std::runtime_error);
}

TEST_F(PlayerApi, CancellingStopsBeforeTheNextRefinementAndOnlyThen) {
  ClipPlayer clip = ClipPlayer::open(path());
  int calls = 0;
  const auto cancelling = [&](const ClipPicture&, bool) {
    ++calls;
    clip.cancel();
    return true;
  };
  clip.render(small_camera(clip), 0, KINORA_PLAYER_COLOR, cancelling);
  EXPECT_EQ(calls, 1);
  EXPECT_EQ(clip.render(small_camera(clip), clip.frame_time(1)).color, expected(1, {0, 1}, player::PictureView::kColor))
      << "later renderings are not cancelled";
}

TEST_F(PlayerApi, SeveralThreadsDrawFromOnePlayer) {
  const ClipPlayer clip = ClipPlayer::open(path());
  const KinoraPlayerCamera camera = small_camera(clip);
  std::vector<std::vector<std::uint8_t>> alone;
  for (std::size_t i = 0; i < clip.info().frames; ++i) alone.push_back(clip.render(camera, clip.frame_time(i)).color);
  std::atomic<int> different = 0;
  {
    std::vector<std::jthread> threads;
    for (std::size_t i = 0; i < 2 * alone.size(); ++i) {
      threads.emplace_back([&, i = i % alone.size()] {
        if (clip.render(camera, clip.frame_time(i)).color != alone[i]) ++different;
        kinora_player_seek(clip.get(), 0.1 * static_cast<double>(i));
      });
    }
  }
  EXPECT_EQ(different, 0);
}

TEST_F(PlayerApi, ErrorsAreStatusAndOneSentence) {
  KinoraPlayer* player = nullptr;
  EXPECT_EQ(kinora_player_open_file("/nowhere/clip.mkv", &player), KINORA_PLAYER_NOT_RECOGNISED);
  EXPECT_EQ(player, nullptr);
  EXPECT_NE(std::string(kinora_player_error()).find("/nowhere/clip.mkv does not exist"), std::string::npos);
  EXPECT_EQ(kinora_player_open_file(nullptr, &player), KINORA_PLAYER_USAGE);
  std::vector<std::byte> cut = bytes();
  cut.resize(cut.size() / 2);
  EXPECT_EQ(kinora_player_open_memory(cut.data(), cut.size(), "half", &player), KINORA_PLAYER_CORRUPT);
  EXPECT_NE(std::string(kinora_player_error()).find("half"), std::string::npos);
  SomeBytes broken;
  broken.bytes = bytes();
  broken.fails = true;
  EXPECT_THROW(ClipPlayer::open(broken), ClipError);
  KinoraPlayerSource small{};
  small.struct_size = 4;
  EXPECT_EQ(kinora_player_open_source(&small, &player), KINORA_PLAYER_USAGE);
}

TEST_F(PlayerApi, CamerasThatAreNoneAreRefused) {
  const ClipPlayer clip = ClipPlayer::open(path());
  const auto refused = [&](const auto& change) {
    KinoraPlayerCamera camera = small_camera(clip);
    change(camera);
    try {
      clip.render(camera, 0);
      return false;
    } catch (const ClipError& error) {
      return error.status() == KINORA_PLAYER_USAGE;
    }
  };
  EXPECT_TRUE(refused([](auto& camera) { camera.width = 0; }));
  EXPECT_TRUE(refused([](auto& camera) { camera.fx = std::numeric_limits<double>::quiet_NaN(); }));
  EXPECT_TRUE(refused([](auto& camera) { camera.camera_to_world[0] = 3; }));
  EXPECT_TRUE(refused([](auto& camera) { camera.camera_to_world[3] = std::numeric_limits<double>::infinity(); }));
  EXPECT_TRUE(refused([](auto& camera) { camera.struct_size = 0; }));
}

TEST_F(PlayerApi, TheClockIsReachedThroughIt) {
  ClipPlayer clip = ClipPlayer::open(path());
  double heard = 0;
  kinora_player_set_master(
      clip.get(), [](void* context) { return *static_cast<double*>(context); }, &heard);
  clip.play();
  heard = clip.frame_time(2) - clip.frame_time(0) + 1e-6;
  EXPECT_EQ(clip.frame(), 2);
  EXPECT_EQ(clip.time(), clip.frame_time(2));
  EXPECT_TRUE(clip.is_playing());
  clip.step(-1);
  EXPECT_FALSE(clip.is_playing());
  EXPECT_EQ(clip.frame(), 1);
  clip.seek(100);
  EXPECT_EQ(clip.frame() + 1, clip.info().frames);
  EXPECT_THROW(clip.set_speed(100), ClipError);
}

} // namespace
} // namespace kinora
