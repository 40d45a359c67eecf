#include "player/backdrops.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "clip/sample_clip.h"
#include "player/player.h"

namespace kinora::player {
namespace {

StillView view_from(double x, int width = 20) {
  StillView view{{{width, 10, 20, 20, 9.5, 4.5}}, {}, {0}};
  view.camera.camera_to_world.translation().x() = x;
  return view;
}

/// How often pictures were drawn for a view that is asked for once more.
class CountedDrawing {
public:
  explicit CountedDrawing(Backdrops& backdrops) : backdrops_(&backdrops) {}
  std::shared_ptr<const fields::Picture> ask(const StillView& view) {
    return backdrops_->picture_of(view, [&] {
      ++drawn;
      return fields::Picture{ColorImage(view.camera.intrinsics.width, view.camera.intrinsics.height, 4), {}, {}};
    });
  }
  int drawn = 0;

private:
  Backdrops* backdrops_;
};

TEST(Backdrops, AreDrawnOnceForViewsThatAreAskedForAgain) {
  Backdrops backdrops;
  CountedDrawing drawing(backdrops);
  EXPECT_EQ(drawing.ask(view_from(1)), nullptr);
  EXPECT_EQ(drawing.drawn, 0);
  const auto picture = drawing.ask(view_from(1));
  ASSERT_NE(picture, nullptr);
  EXPECT_EQ(drawing.ask(view_from(1)), picture);
  EXPECT_EQ(drawing.drawn, 1);
}

TEST(Backdrops, AreOfOneCameraOneSetOfOptionsAndTheSameLayers) {
  Backdrops backdrops;
  CountedDrawing drawing(backdrops);
  drawing.ask(view_from(1));
  StillView other = view_from(1);
  other.layers = {0, 2};
  EXPECT_EQ(drawing.ask(other), nullptr);
  other = view_from(1);
  other.options.samples = 2;
  EXPECT_EQ(drawing.ask(other), nullptr);
  other = view_from(1);
  other.camera.intrinsics.cx += 0.5;
  EXPECT_EQ(drawing.ask(other), nullptr);
  EXPECT_NE(drawing.ask(view_from(1)), nullptr);
}

TEST(Backdrops, OfManyViewsTheLastAreKept) {
  Backdrops backdrops;
  CountedDrawing drawing(backdrops);
  for (int i = 0; i < 3; ++i) {
    for (std::size_t v = 0; v < Backdrops::kMaxViews; ++v) drawing.ask(view_from(static_cast<double>(v)));
  }
  EXPECT_EQ(drawing.drawn, static_cast<int>(Backdrops::kMaxViews));
  drawing.ask(view_from(99));
  EXPECT_NE(drawing.ask(view_from(1)), nullptr);
  EXPECT_EQ(drawing.ask(view_from(0)), nullptr); // the one asked for longest ago
}

TEST(Backdrops, HaveNoMorePixelsTogetherThanIsAllowed) {
  Backdrops backdrops;
  CountedDrawing drawing(backdrops);
  constexpr int kWidth = Backdrops::kMaxPixels / 10 / 2;
  for (int i = 0; i < 2; ++i) {
    for (int v = 0; v < 3; ++v) drawing.ask(view_from(v, kWidth));
  }
  EXPECT_EQ(drawing.drawn, 3);
  EXPECT_EQ(drawing.ask(view_from(0, kWidth)), nullptr);
  const StillView large = view_from(5, 3 * kWidth);
  drawing.ask(large);
  EXPECT_EQ(drawing.ask(large), drawing.ask(large)); // one alone may be larger
}

TEST(Backdrops, PicturesOfAClipAreTheSameWithThem) {
  clip::Clip clip = clip::testing::sample_clip(1, 5, false);
  clip.layers[0].motion = motion::Motion::still();
  const Player again(clip);
  Camera camera = clip.capture_camera(0);
  camera.intrinsics = camera.intrinsics.resized(64, 48);
  for (const double frame : {0.0, 1.0, 1.5, 4.0, 0.0}) {
    const fields::Picture picture = again.draw(camera, frame, again.all_layers());
    const fields::Picture alone = Player(clip).draw(camera, frame, again.all_layers());
    EXPECT_TRUE(std::ranges::equal(picture.color.values(), alone.color.values())) << frame;
    EXPECT_TRUE(std::ranges::equal(picture.depth.values(), alone.depth.values())) << frame;
    EXPECT_TRUE(std::ranges::equal(picture.front.values(), alone.front.values())) << frame;
  }
}

} // namespace
} // namespace kinora::player
