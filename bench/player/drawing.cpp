// How long a clip takes to draw: frames all over it, seen by the capture's camera, by cameras 15° and 45° to either
// side and by one from 30° above (carry_box's novel cameras stand up to 45° aside and 28° above). Prints the machine's
// own speed, then CSV; median_ms is of all pictures, slowest_camera_ms of the camera whose pictures take longest.
//   bench_drawing CLIP.mkv [threads=1,2] [size=640x480,1280x720] [quality=full,fast] [target=avx2]
// target: draws with these instructions (bench/instruction_set.h) instead of the best that there are.
#include <algorithm>
#include <cstdio>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "clip/clip_io.h"
#include "core/parallel.h"
#include "fields/calibration.h"
#include "instruction_set.h"
#include "player/player.h"
#include "player/view_path.h"
#include "stopwatch.h"

using namespace kinora;

namespace {

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

/// The capture's camera carried up, over the point that orbits go about at the camera's own height.
player::View raised_view(const player::Player& player, int frame, double degrees) {
  player::View view = player::capture_views(player.clip(), {frame}).front();
  const SE3 camera = view.camera.camera_to_world;
  const SE3 opposite = player::orbit_views(player, {frame}, 180).front().camera.camera_to_world;
  const Eigen::Translation3d pivot((camera.translation() + opposite.translation()) / 2);
  const Eigen::Vector3d right = camera.linear().col(0);
  view.camera.camera_to_world =
      pivot * Eigen::AngleAxisd(-degrees * std::numbers::pi / 180, right) * pivot.inverse() * camera;
  return view;
}

/// For each camera its views of the same frames.
std::vector<std::vector<player::View>> views_of(const player::Player& player, int width, int height) {
  constexpr int kFrames = 7;
  std::vector<std::vector<player::View>> cameras(6);
  for (int i = 0; i < kFrames; ++i) {
    const int frame = static_cast<int>(player.frame_count() - 1) * i / (kFrames - 1);
    auto camera = cameras.begin();
    for (const double degrees : {0.0, -15.0, 15.0, -45.0, 45.0}) {
      (camera++)->push_back(player::orbit_views(player, {frame}, degrees).front());
    }
    camera->push_back(raised_view(player, frame, 30));
  }
  for (auto& views : cameras) {
    for (player::View& view : views) view.camera.intrinsics = view.camera.intrinsics.resized(width, height);
  }
  return cameras;
}

void measure(const player::Player& player, fields::DrawQuality quality, int threads, int width, int height) {
  set_thread_count(threads);
  std::vector<double> milliseconds, processor;
  double slowest_camera = 0;
  for (const std::vector<player::View>& views : views_of(player, width, height)) {
    std::vector<double> of_camera;
    for (const player::View& view : views) {
      const bench::Stopwatch watch;
      player.draw(view.camera, view.frame, player.all_layers(), {quality});
      of_camera.push_back(watch.milliseconds());
      processor.push_back(watch.processor_milliseconds());
    }
    slowest_camera = std::max(slowest_camera, median(of_camera));
    milliseconds.insert(milliseconds.end(), of_camera.begin(), of_camera.end());
  }
  std::printf("%s,%dx%d,%d,%.1f,%.1f,%.1f,%.1f\n", quality == fields::DrawQuality::kFull ? "full" : "fast", width,
              height, threads, median(milliseconds), slowest_camera,
              *std::max_element(milliseconds.begin(), milliseconds.end()), median(processor));
}

std::vector<std::string> values_of(const std::string& argument) {
  std::vector<std::string> values;
  std::istringstream list(argument.substr(argument.find('=') + 1));
  for (std::string value; std::getline(list, value, ',');) values.push_back(value);
  return values;
}

} // namespace

int main(int argc, char** argv) {
  std::vector<std::string> threads{"1", "2"};
  std::vector<std::string> sizes{"640x480", "1280x720"};
  std::vector<std::string> qualities{"full", "fast"};
  if (argc < 2) {
    std::fprintf(
        stderr,
        "usage: bench_drawing CLIP.mkv [threads=1,2] [size=640x480,1280x720] [quality=full,fast] [target=avx2]\n");
    return 2;
  }
  try {
    for (int i = 2; i < argc; ++i) {
      const std::string argument = argv[i];
      if (argument.starts_with("threads=")) threads = values_of(argument);
      if (argument.starts_with("size=")) sizes = values_of(argument);
      if (argument.starts_with("quality=")) qualities = values_of(argument);
      if (argument.starts_with("target=")) bench::use_instruction_set(values_of(argument).at(0));
    }
    bench::print_calibration();
    const bench::Stopwatch watch;
    const player::Player player(clip::read_clip(argv[1]));
    std::printf("# opened in %.2f s\n", watch.milliseconds() / 1000);
    std::printf("quality,size,threads,median_ms,slowest_camera_ms,largest_ms,median_processor_ms\n");
    for (const std::string& name : qualities) {
      const auto quality = name == "fast" ? fields::DrawQuality::kFast : fields::DrawQuality::kFull;
      for (const std::string& size : sizes) {
        const std::size_t cross = size.find('x');
        for (const std::string& count : threads) {
          measure(player, quality, std::stoi(count), std::stoi(size.substr(0, cross)),
                  std::stoi(size.substr(cross + 1)));
        }
      }
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_drawing: %s\n", error.what());
    return 1;
  }
  return 0;
}
