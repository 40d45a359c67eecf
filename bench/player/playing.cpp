// A clip as it plays: every frame once, in order of time, from the capture's camera and from 30° aside, at full
// quality. Prints the machine's own speed and what opening costs, then CSV: decode_ms is the reading of the whole file
// divided by its frames; warp_ms carries every layer to the frame's time and render_ms draws it, medians of all frames;
// frames_per_s is what all three sustain from the first frame to the last on the clock, processor_ms what all threads
// together spend for a frame.
//   bench_playing CLIP.mkv [threads=1,2] [size=640x480,1280x720] [aside=0,30] [target=avx2]
// target: draws with these instructions (bench/instruction_set.h) instead of the best that there are.
#include <algorithm>
#include <cstdio>
#include <sstream>
#include <string>
#include <vector>

#include "clip/clip_io.h"
#include "clip/shown_frames.h"
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

/// Layers in the form in which they are drawn, as player::Player holds them.
std::vector<fields::DrawableField> drawables_of(const clip::Clip& clip) {
  std::vector<fields::DrawableField> drawables;
  drawables.reserve(clip.layers.size());
  for (const clip::Layer& layer : clip.layers) {
    drawables.emplace_back(layer.field, layer.motion.graph().get(), layer.confidence);
  }
  return drawables;
}

std::vector<fields::PosedField> posed(const clip::Clip& clip, const std::vector<fields::DrawableField>& drawables,
                                      double frame) {
  std::vector<fields::PosedField> posed;
  posed.reserve(drawables.size());
  for (std::size_t i = 0; i < drawables.size(); ++i) {
    if (!clip::shown_frames(clip.layers[i], clip.times.size()).at(frame)) continue;
    posed.push_back(fields::pose(drawables[i], clip.layers[i].motion.warp(frame)));
  }
  return posed;
}

struct Play {
  int threads, width, height;
  double aside;
};

void measure(const player::Player& player, const std::vector<fields::DrawableField>& drawables, double decode,
             const Play& play) {
  set_thread_count(play.threads);
  const clip::Clip& clip = player.clip();
  std::vector<double> warp, render;
  const bench::Stopwatch whole;
  for (std::size_t i = 0; i < player.frame_count(); ++i) {
    player::View view = player::orbit_views(player, {static_cast<int>(i)}, play.aside).front();
    view.camera.intrinsics = view.camera.intrinsics.resized(play.width, play.height);
    const bench::Stopwatch watch;
    const std::vector<fields::PosedField> layers = posed(clip, drawables, view.frame);
    warp.push_back(watch.milliseconds());
    fields::DrawOptions options;
    options.samples = player::samples_per_side(view.camera.intrinsics, clip.intrinsics);
    fields::render(layers, view.camera, options);
    render.push_back(watch.milliseconds() - warp.back());
  }
  const auto frames = static_cast<double>(player.frame_count());
  const double processor = whole.processor_milliseconds() / frames + decode;
  const double clock = whole.milliseconds() / frames + decode;
  std::printf("%dx%d,%g,%d,%.2f,%.2f,%.2f,%.1f,%.2f\n", play.width, play.height, play.aside, play.threads, decode,
              median(warp), median(render), 1000 / clock, processor);
  std::fflush(stdout);
}

} // namespace

int main(int argc, char** argv) {
  std::vector<std::string> threads{"2"};
  std::vector<std::string> sizes{"640x480", "1280x720"};
  std::vector<std::string> asides{"0", "30"};
  if (argc < 2) {
    std::fprintf(stderr, "usage: bench_playing CLIP.mkv [threads=1,2] [size=640x480,1280x720] [aside=0,30] "
                         "[target=avx2]\n");
    return 2;
  }
  try {
    for (int i = 2; i < argc; ++i) {
      const std::string argument = argv[i];
      if (argument.starts_with("threads=")) threads = values_of(argument);
      if (argument.starts_with("size=")) sizes = values_of(argument);
      if (argument.starts_with("aside=")) asides = values_of(argument);
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
    const std::vector<fields::DrawableField> drawables = drawables_of(player.clip());
    std::printf("size,aside,threads,decode_ms,warp_ms,render_ms,frames_per_s,processor_ms\n");
    for (const std::string& size : sizes) {
      const std::size_t cross = size.find('x');
      for (const std::string& aside : asides) {
        for (const std::string& count : threads) {
          measure(player, drawables, read / static_cast<double>(player.frame_count()),
                  {std::stoi(count), std::stoi(size.substr(0, cross)), std::stoi(size.substr(cross + 1)),
                   std::stod(aside)});
        }
      }
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_playing: %s\n", error.what());
    return 1;
  }
  return 0;
}
