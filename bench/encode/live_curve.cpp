// A capture encoded live at its own pace, and then offline: how good the picture is from the truth's cameras, against
// the seconds since the first frame. Of every clip that live encoding gives, the last frame is seen by all cameras that
// there is truth for; of the last live clip and of the offline one, all frames are, too. CSV:
//   bench_live_curve CAPTURE [PRESET]
// `what`: live, live_end (all frames of the last clip), offline_end (when offline encoding has ended, all frames);
// dB: PSNR within the box of everything that is labelled; within its silhouette, of the person alone.
#include <chrono>
#include <cstdio>

#include "encode/live/live_encoder.h"
#include "host/plugin_table.h"
#include "host/simulated_device.h"
#include "novel_look.h"

namespace {

using namespace kinora;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

using Looks = std::map<std::string, evaluate::Means>;

/// Looks at frame `i` of the clip by all cameras that there is truth for; false if there is none.
bool look_at(const player::Player& player, std::size_t i, const evaluate::GroundTruth& truth, Looks& looks) {
  const int number = player.clip().capture_frames[i];
  bool any = false;
  for (const evaluate::NovelCamera& camera : truth.novel_cameras()) {
    if (std::ranges::find(camera.frames, number) == camera.frames.end()) continue;
    bench::look(player, static_cast<double>(i), camera, truth.novel_view(camera, number), looks);
    any = true;
  }
  return any;
}

void print(const char* what, double seconds, const clip::Clip& clip, Looks& looks) {
  std::printf("%s,%.2f,%zu,%.2f,%.2f\n", what, seconds, clip.times.size(),
              looks["foreground"].mean("psnr_box").value_or(0), looks["person"].mean("psnr").value_or(0));
  std::fflush(stdout);
}

void print_all_frames(const char* what, double seconds, const clip::Clip& clip, const evaluate::GroundTruth& truth) {
  const player::Player player(clip);
  Looks looks;
  for (std::size_t i = 0; i < clip.times.size(); ++i) look_at(player, i, truth, looks);
  print(what, seconds, clip, looks);
}

void run(const char* path, encode::Preset preset) {
  const host::PluginTable plugins = host::PluginTable::builtin();
  Progress progress;
  const auto truth = evaluate::GroundTruth::read(path);
  if (!truth || truth->novel_cameras().empty()) throw std::runtime_error("it has no pictures of other cameras");
  const encode::EncodeOptions options = encode::EncodeOptions::of(preset);

  ingest::CaptureOptions how;
  how.device = std::make_shared<host::SimulatedDevice>(std::vector<host::DeviceFault>{}, 0.05,
                                                       host::DeviceClock::steady(), [] { return false; });
  const auto capture = ingest::Capture::open(plugins, path, how, progress);
  std::vector<std::pair<double, clip::Clip>> clips;
  const Clock::time_point start = Clock::now();
  encode::LiveRequest request;
  request.interval = 0.3;
  request.publish = [&](const clip::Clip& clip) { clips.emplace_back(seconds_since(start), clip); };
  const encode::EncodeResult live = encode::encode_live(*capture, request, options, progress);
  const double live_end = seconds_since(start);
  std::fprintf(stderr, "%s\n", live.report["live"].dump(1).c_str());

  std::printf("what,seconds,frames,both_box_db,person_db\n");
  for (const auto& [seconds, clip] : clips) {
    const player::Player player(clip);
    Looks looks;
    std::size_t i = clip.times.size();
    while (i > 0 && !look_at(player, i - 1, *truth, looks)) --i;
    print("live", seconds, clip, looks);
  }
  print_all_frames("live_end", live_end, live.clip, *truth);
  clips.clear();

  encode::CaptureRequest offline;
  offline.open = [&](const ingest::CaptureOptions& opened, Progress& to) {
    return ingest::Capture::open(plugins, path, opened, to);
  };
  const Clock::time_point again = Clock::now();
  const encode::EncodeResult result =
      encode::encode_capture(encode::prepare_capture(offline, progress), options, progress);
  print_all_frames("offline_end", seconds_since(again), result.clip, *truth);
}

} // namespace

int main(int argc, char** argv) {
  if (argc < 2 || argc > 3) {
    std::fprintf(stderr, "usage: bench_live_curve CAPTURE [PRESET]\n");
    return 2;
  }
  try {
    run(argv[1], encode::parse_preset(argc > 2 ? argv[2] : "balanced"));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_live_curve: %s\n", error.what());
    return 1;
  }
  return 0;
}
