// A person whose hands move faster than alignment alone can follow.
#include <algorithm>
#include <span>
#include <string_view>

#include <gtest/gtest.h>

#include "tracking/body/person_camera.h"
#include "tracking/deforming_tracker.h"
#include "tracking/point_track.h"

namespace kinora::tracking {
namespace {

constexpr std::size_t kPoints = 200;

struct Followed {
  int not_tracked = 0;
  double mean_error = 0; ///< metres, of points on `parts` while they are seen, each from where it was seen first
  double seam = 0;       ///< metres, in the last frame, of points that are seen in it and in the first
};

Followed follow(std::string_view name, int frames, std::span<const std::size_t> parts,
                const testing::PersonCamera& camera = {320, 240, 262.5}) {
  testing::PersonScene scene = testing::person_scene(name);
  scene.frames = frames;
  DeformingTracker tracker(1);
  Followed result;
  for (int i = 0; i < frames; ++i) {
    if (tracker.track(testing::see_person(scene, i, camera)).health != Health::kTracked) ++result.not_tracked;
  }
  const Motion motion = tracker.motion();
  double count = 0;
  double at_both_ends = 0;
  for (const auto& [id, places] : testing::track_person(scene, kPoints, camera, parts)) {
    const auto first =
        std::find_if(places.begin(), places.end(), [](const auto& place) { return place.second.visible; });
    if (first == places.end()) continue;
    const auto track = track_point(motion, static_cast<std::size_t>(frames), static_cast<std::size_t>(first->first),
                                   first->second.point);
    for (const auto& [frame, place] : places) {
      if (!place.visible) continue;
      const double error = (track[static_cast<std::size_t>(frame)] - place.point).norm();
      result.mean_error += error;
      ++count;
      if (first->first > 0 || frame + 1 < frames) continue;
      result.seam += error;
      ++at_both_ends;
    }
  }
  result.mean_error /= count;
  result.seam /= at_both_ends;
  return result;
}

// 66 mm if limbs begin where their own velocity leads to alone.
TEST(FastPerson, AHandThatWavesAt25CentimetresAFrameIsFollowed) {
  const auto& parts = testing::person_scene("hands").fast_parts;
  const Followed wave = follow("hands", 44, std::span(parts).subspan(2));
  EXPECT_EQ(wave.not_tracked, 0);
  EXPECT_LT(wave.mean_error, 0.015);
}

// At 240 lines hands are glued together: 38 mm.
TEST(FastPerson, HandsThatClapPartAgain) {
  const Followed clap = follow("clap", 40, testing::person_scene("clap").fast_parts, {480, 360, 394});
  EXPECT_EQ(clap.not_tracked, 0);
  EXPECT_LT(clap.mean_error, 0.008);
}

TEST(FastPerson, AFullTurnEndsWhereItBegan) {
  const Followed turn = follow("turn", 62, {});
  EXPECT_EQ(turn.not_tracked, 0);
  EXPECT_LT(turn.mean_error, 0.010);
  printf("turn %.1f seam %.1f\n", 1e3 * turn.mean_error, 1e3 * turn.seam);
  EXPECT_LT(turn.seam, 0.020);
}

} // namespace
} // namespace kinora::tracking
