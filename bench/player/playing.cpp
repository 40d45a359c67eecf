// A clip as it plays: all its frames three times over, seen by the camera that captured its first frame and from 30°
// aside, at full quality; either camera rests, or turns about the subject by a quarter of a degree from frame to frame.
// Prints the machine's own speed and what opening costs, then CSV: decode_ms is the reading of the whole file divided
// by the frames that are shown; warp_ms carries every layer to the frame's time and render_ms draws it, medians of all
// frames; frames_per_s is what all three sustain from the first frame to the last on the clock, processor_ms what all
// threads together spend for a frame.
//   bench_playing CLIP.mkv [threads=1,2] [size=640x480,1280x720] [aside=0,30] [camera=rests,turns] [target=avx2]
// target: draws with these instructions (bench/instruction_set.h) instead of the best that there are.
#include <algorithm>
#include <cstdio>
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

std::vector<std::string> values_of(const std::string& argument) {
  std::vector<std::string> values;
  std::istringstream list(argument.substr(argument.find('=') + 1));
  for (std::string value; std::getline(list, value, ',');) values.push_back(value);
  return values;
}

struct Play {
  int threads, width, height;
  double aside;
  std::string camera;
};

constexpr int kRounds = 3;
constexpr double kTurn = 0.25; // degrees a frame

void measure(const player::Player& player, double reading, const Play& play) {
  set_thread_count(play.threads);
  std::vector<double> warp, render;
  const bench::Stopwatch whole;
  const auto frames = static_cast<double>(kRounds * player.frame_count());
  for (int i = 0; i < static_cast<int>(frames); ++i) {
    const double degrees = play.aside + (play.camera == "turns" ? kTurn * i : 0);
    player::View view = player::orbit_views(player, {0}, degrees).front();
    view.frame = i % static_cast<int>(player.frame_count());
    view.camera.intrinsics = view.camera.intrinsics.resized(play.width, play.height);
    const bench::Stopwatch watch;
    player.posed_layers(view.frame, player.all_layers()); // kept for what follows
    warp.push_back(watch.milliseconds());
    player.draw(view.camera, view.frame, player.all_layers());
    render.push_back(watch.milliseconds() - warp.back());
  }
  const double decode = reading / frames;
  const double processor = whole.processor_milliseconds() / frames + decode;
  const double clock = whole.milliseconds() / frames + decode;
  std::printf("%dx%d,%g,%s,%d,%.2f,%.2f,%.2f,%.1f,%.2f\n", play.width, play.height, play.aside, play.camera.c_str(),
              play.threads, decode, median(warp), median(render), 1000 / clock, processor);
  std::fflush(stdout);
}

} // namespace

int main(int argc, char** argv) {
  std::vector<std::string> threads{"2"};
  std::vector<std::string> sizes{"640x480", "1280x720"};
  std::vector<std::string> asides{"0", "30"};
  std::vector<std::string> cameras{"rests", "turns"};
  if (argc < 2) {
    std::fprintf(stderr, "usage: bench_playing CLIP.mkv [threads=1,2] [size=640x480,1280x720] [aside=0,30] "
                         "[camera=rests,turns] [target=avx2]\n");
    return 2;
  }
  try {
    for (int i = 2; i < argc; ++i) {
      const std::string argument = argv[i];
      if (argument.starts_with("threads=")) threads = values_of(argument);
      if (argument.starts_with("size=")) sizes = values_of(argument);
      if (argument.starts_with("aside=")) asides = values_of(argument);
      if (argument.starts_with("camera=")) cameras = values_of(argument);
      if (argument.starts_with("target=")) bench::use_instruction_set(values_of(argument).at(0));
    }
    bench::print_calibration();
    const bench::Stopwatch reading;
    clip::Clip clip = clip::read_clip(argv[1]);
    const double read = reading.processor_milliseconds();
    const bench::Stopwatch preparing;
    const player::Player player(std::move(clip));
    std::printf("# %zu frames, read in %.0f ms and made ready in %.0f ms of processor time\n", player.frame_count(),
                read, preparing.processor_milliseconds());
    std::printf("size,aside,camera,threads,decode_ms,warp_ms,render_ms,frames_per_s,processor_ms\n");
    for (const std::string& size : sizes) {
      const std::size_t cross = size.find('x');
      for (const std::string& aside : asides) {
        for (const std::string& camera : cameras) {
          for (const std::string& count : threads) {
            measure(player, read,
                    {std::stoi(count), std::stoi(size.substr(0, cross)), std::stoi(size.substr(cross + 1)),
                     std::stod(aside), camera});
          }
        }
      }
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_playing: %s\n", error.what());
    return 1;
  }
  return 0;
}
