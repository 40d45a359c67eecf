// How soon a clip is seen, how soon it is seen elsewhere, and what memory that takes. Prints the machine's own speed,
// then a line for each:
//   file to its first picture, and over a connection of so many Mbit/s (with 20 ms until a request is answered) to the
//   first picture and until all has come: read, made ready and drawn at 640×480 as a window at rest would;
//   200 seeks to random frames at random sides, each until its full picture: median and longest;
//   resident memory after that, and after playing so many more frames, small, from changing sides: what grows would
//   show. bench_opening CLIP.mkv [mbit=10] [frames=10000]
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "fields/calibration.h"
#include "player/clip_feed.h"
#include "player/view_path.h"
#include "stopwatch.h"

using namespace kinora;

namespace {

/// A file as a connection would give it.
class ThrottledSource final : public container::ByteSource {
public:
  ThrottledSource(const std::string& path, double megabits_per_second)
      : file_(path), microseconds_per_byte_(8 / megabits_per_second) {}

  const std::string& name() const override { return file_.name(); }
  std::uint64_t size() const override { return file_.size(); }
  void read(std::uint64_t offset, std::span<std::byte> out) override {
    const double wait = kAnswer + microseconds_per_byte_ * static_cast<double>(out.size());
    std::this_thread::sleep_for(std::chrono::microseconds(static_cast<long>(wait)));
    file_.read(offset, out);
  }

private:
  static constexpr double kAnswer = 20'000; // microseconds
  container::FileSource file_;
  double microseconds_per_byte_;
};

double resident_megabytes(const char* which) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with(which)) return std::stod(line.substr(std::strlen(which) + 1)) / 1024;
  }
  return 0;
}

void draw(const player::Player& player, int frame, double degrees, int width, int height) {
  player::View view = player::orbit_views(player, {frame}, degrees).front();
  view.camera.intrinsics = view.camera.intrinsics.resized(width, height);
  player.draw(view.camera, view.frame, player.all_layers());
}

/// The whole clip.
player::ClipSoFar open(const char* words, std::unique_ptr<container::ByteSource> source) {
  const auto never = [] { return false; };
  const bench::Stopwatch watch;
  const player::ClipFeed feed(std::move(source));
  const player::ClipSoFar first = feed.first(never);
  draw(*first.player, 0, 0, 640, 480);
  const bool first_look = first.player->readiness() == player::Readiness::kFirstLook;
  std::printf("%s: first picture after %.0f ms, of %zu layers and %zu frames, %s", words, watch.milliseconds(),
              first.player->clip().layers.size(), first.player->frame_count(), first_look ? "a first look" : "ready");
  player::ClipSoFar now = first;
  for (; !now.complete; now = feed.newest()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  std::printf("; complete after %.0f ms, %.0f ms of processor time\n", watch.milliseconds(),
              watch.processor_milliseconds());
  std::fflush(stdout);
  return now;
}

void seek(const player::Player& player) {
  constexpr int kSeeks = 200;
  std::mt19937 random(1); // NOLINT: the same seeks each time
  std::vector<double> milliseconds;
  for (int i = 0; i < kSeeks; ++i) {
    const int frame = static_cast<int>(random() % player.frame_count());
    const double degrees = static_cast<double>(random() % 90) - 45;
    const bench::Stopwatch watch;
    draw(player, frame, degrees, 640, 480);
    milliseconds.push_back(watch.milliseconds());
  }
  std::sort(milliseconds.begin(), milliseconds.end());
  std::printf("%d seeks: %.0f ms, the longest %.0f ms\n", kSeeks, milliseconds[kSeeks / 2], milliseconds.back());
  std::fflush(stdout);
}

void play(const player::Player& player, int frames) {
  const double before = resident_megabytes("VmRSS:");
  for (int i = 0; i < frames; ++i) {
    draw(player, i % static_cast<int>(player.frame_count()), i % 60 - 30, 32, 24);
  }
  std::printf("resident: %.1f MB, after %d frames more %.1f MB; at most %.1f MB\n", before, frames,
              resident_megabytes("VmRSS:"), resident_megabytes("VmHWM:"));
}

} // namespace

int main(int argc, char** argv) {
  double megabits = 10;
  int frames = 10'000;
  if (argc < 2) {
    std::fprintf(stderr, "usage: bench_opening CLIP.mkv [mbit=10] [frames=10000]\n");
    return 2;
  }
  try {
    for (int i = 2; i < argc; ++i) {
      const std::string argument = argv[i];
      if (argument.starts_with("mbit=")) megabits = std::stod(argument.substr(5));
      if (argument.starts_with("frames=")) frames = std::stoi(argument.substr(7));
    }
    bench::print_calibration();
    open("file", std::make_unique<container::FileSource>(argv[1]));
    const player::ClipSoFar clip = open("connection", std::make_unique<ThrottledSource>(argv[1], megabits));
    seek(*clip.player);
    play(*clip.player, frames);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_opening: %s\n", error.what());
    return 1;
  }
  return 0;
}
