// Follows a camera around rooms where it drifts farther than alignment reaches: errors of the whole path with the first
// frames laid together, and milliseconds per frame, for several seeds of each scene
// (tests/tracking/scenes/loop_scenes.h). Usage: bench_tracking_loops [SEEDS]: how many of each (default 3); with
// KINORA_BENCH_FRAMES set, also frame by frame.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>

#include "follow_label.h"
#include "tracking/camera/camera_tracker.h"
#include "tracking/scenes/loop_scenes.h"

namespace {

using namespace kinora;
using bench::at_fraction;
using tracking::testing::LoopScene;

constexpr double kDegrees = 180 / 3.14159265358979;

void follow(const LoopScene& scene, std::uint64_t seed) {
  tracking::CameraTracker tracker;
  std::vector<double> milliseconds;
  int tracked = 0;
  for (std::size_t i = 0; i < scene.size(); ++i) {
    const ingest::Frame frame = scene.render(i);
    const auto start = std::chrono::steady_clock::now();
    const tracking::CameraTrackingResult result = tracker.track(frame);
    milliseconds.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    tracked += result.health == motion::Health::kTracked ? 1 : 0;
    if (std::getenv("KINORA_BENCH_FRAMES") == nullptr) continue;
    const SE3 off = (scene.truth.front().inverse() * scene.truth[i]).inverse() * tracker.path().back();
    std::printf("frame %zu: %s, %.0f mm, %.1f degrees off, share %.2f, texture %.2f, %zu key frames, %zu loops\n", i,
                std::string(motion::name_of(result.health)).c_str(), 1e3 * off.translation().norm(),
                kDegrees * rotation_angle(off), result.quality.inlier_share(), result.quality.texture_correlation,
                tracker.keyframe_count(), tracker.loop_count());
  }
  const std::vector<SE3> path = tracker.path();
  double squares = 0;
  double worst = 0;
  double worst_rotation = 0;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const SE3 off = (scene.truth.front().inverse() * scene.truth[i]).inverse() * path[i];
    squares += off.translation().squaredNorm();
    worst = std::max(worst, off.translation().norm());
    worst_rotation = std::max(worst_rotation, kDegrees * rotation_angle(off));
  }
  const SE3 last = (scene.truth.front().inverse() * scene.truth.back()).inverse() * path.back();
  std::printf("%-16s %llu: %zu of %zu tracked, %zu key frames, %zu loops; %.0f mm, worst %.0f mm, %.1f degrees; at the "
              "end %.0f mm, %.1f degrees; median %.1f ms, longest %.1f ms\n",
              scene.name.c_str(), static_cast<unsigned long long>(seed), static_cast<std::size_t>(tracked),
              scene.size(), tracker.keyframe_count(), tracker.loop_count(),
              1e3 * std::sqrt(squares / static_cast<double>(path.size())), 1e3 * worst, worst_rotation,
              1e3 * last.translation().norm(), kDegrees * rotation_angle(last), at_fraction(milliseconds, 0.5),
              at_fraction(milliseconds, 1));
}

} // namespace

int main(int argc, char** argv) {
  const auto seeds = static_cast<std::uint64_t>(argc > 1 ? std::atoi(argv[1]) : 3);
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    follow(tracking::testing::rotate_around(seed), seed);
    follow(tracking::testing::rotate_with_hard_stretches(seed), seed);
    follow(tracking::testing::covered_on_the_way(seed), seed);
    follow(tracking::testing::alike_place(seed, 1), seed);
  }
  return 0;
}
