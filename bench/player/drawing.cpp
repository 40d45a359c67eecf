// How long a clip takes to draw: frames all over it, seen by the capture camera and by cameras up to 30° aside.
// usage: bench_drawing CLIP.mkv [threads=1,2] [size=640x480,1280x720] [quality=full,fast] [target=avx2]
// target: draws with these instructions (bench/instruction_set.h) instead of the best that there are.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <sstream>
#include <string>
#include <vector>

#include "core/parallel.h"
#include "encode/clip_io.h"
#include "fields/kernels.h"
#include "instruction_set.h"
#include "player/camera_path.h"
#include "player/player.h"

using namespace kinora;

namespace {

/// Of all threads of this process.
double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

double median(std::vector<double>& values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

std::vector<player::View> views_of(const player::Player& player, int width, int height) {
  constexpr int kFrames = 7;
  std::vector<player::View> views;
  for (const double degrees : {0.0, -10.0, 10.0, -30.0, 30.0}) {
    for (int i = 0; i < kFrames; ++i) {
      const int frame = static_cast<int>(player.frame_count() - 1) * i / (kFrames - 1);
      views.push_back(player::orbit_views(player, {frame}, degrees).front());
      views.back().camera.intrinsics = views.back().camera.intrinsics.resized(width, height);
    }
  }
  return views;
}

void measure(const player::Player& player, fields::DrawQuality quality, int threads, int width, int height) {
  set_thread_count(threads);
  std::vector<double> milliseconds, processor;
  for (const player::View& view : views_of(player, width, height)) {
    const auto begin = std::chrono::steady_clock::now();
    const double processor_begin = processor_seconds();
    player.draw(view.camera, view.frame, player.all_layers(), {quality});
    milliseconds.push_back(1000 * seconds_since(begin));
    processor.push_back(1000 * (processor_seconds() - processor_begin));
  }
  const double typical = median(milliseconds);
  std::printf("%s,%dx%d,%d,%.1f,%.1f,%.1f\n", quality == fields::DrawQuality::kFull ? "full" : "fast", width, height,
              threads, typical, milliseconds.back(), median(processor));
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
    const auto begin = std::chrono::steady_clock::now();
    const player::Player player(encode::read_clip(argv[1]));
    std::printf("# opened in %.2f s; %s\nquality,size,threads,median_ms,largest_ms,median_processor_ms\n",
                seconds_since(begin), fields::kernels::instruction_set());
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
