// Live training with several rules for key frames, sizes of their pool, and with and without refinement for the view
// that is asked for: every tenth frame is looked at from one of the truth's cameras, the next one each time, as a
// viewer would while the performance goes on. The capture runs forth and back. All rows have as many rays: without
// refinement, those of the burst before each look are of all key frames.
//   bench_key_frames CAPTURE [FRAMES [SEEDS]]        (default: 300 frames, 1 seed)
// Prints means over all looks from the second second on: PSNR of the person and of the object alone, within their
// silhouettes, and of both together within their box (core/metrics.h). The motion is tracked once for all.
#include <cstdio>
#include <cstdlib>

#include "encode/live/key_frame_pool.h"
#include "encode/live/live_trainer.h"
#include "host/plugin_table.h"
#include "ingest/capture/capture.h"
#include "novel_look.h"

namespace {

using namespace kinora;

constexpr int kFramesPerRound = 12; ///< what two cores train in 0.4 s
constexpr int kFramesPerLook = 10;
constexpr int kFirstLook = 30;

struct Performance {
  std::vector<std::shared_ptr<const ingest::Frame>> frames;
  std::vector<int> captured; ///< number of each in the capture
  std::map<int, encode::LiveSnapshot> snapshots;
};

bool is_round(int frame) { return frame % kFramesPerRound == 0; }

Performance perform(ingest::Capture& capture, int count, const encode::EncodeOptions& options) {
  std::vector<std::shared_ptr<const ingest::Frame>> captured;
  while (auto frame = capture.next()) captured.push_back(std::make_shared<const ingest::Frame>(std::move(*frame)));
  const int length = static_cast<int>(captured.size());
  Progress progress;
  encode::StageTimes times;
  encode::FrontEnd front_end(capture.info(), options, progress);
  Performance performance;
  for (int i = 0; i < count; ++i) {
    const int phase = length > 1 ? i % (2 * length - 2) : 0;
    const int number = phase < length ? phase : 2 * length - 2 - phase;
    auto frame = std::make_shared<ingest::Frame>(*captured[static_cast<std::size_t>(number)]);
    frame->index = i;
    frame->time = i / capture.info().frames_per_second;
    front_end.add(*frame, false, times);
    performance.frames.push_back(std::move(frame));
    performance.captured.push_back(number);
    if (is_round(i) || number % kFramesPerLook == 0)
      performance.snapshots.emplace(i, snapshot_of(front_end.timeline(), front_end.labels(), false));
  }
  return performance;
}

void run(const Performance& performance, const evaluate::GroundTruth& truth, const encode::EncodeOptions& options,
         bool refines, std::map<std::string, evaluate::Means>& means) {
  Progress progress;
  encode::KeyFramePool pool(options.settings.live.key_frames);
  encode::LiveTrainer trainer(options);
  const encode::LiveTrainingConfig& config = options.settings.live.training;
  std::size_t shown = 0, looks = 0;
  for (const auto& [last, snapshot] : performance.snapshots) {
    for (; shown <= static_cast<std::size_t>(last); ++shown)
      pool.add({static_cast<int>(shown), performance.frames[shown]}, snapshot);
    if (is_round(last)) trainer.train(snapshot, pool.frames(), last == 0 ? config.first_rays : config.rays, progress);
    if (last < kFirstLook) continue;
    const evaluate::NovelCamera& camera = truth.novel_cameras()[looks % truth.novel_cameras().size()];
    const int number = performance.captured[static_cast<std::size_t>(last)];
    if (std::ranges::find(camera.frames, number) == camera.frames.end()) continue;
    ++looks;
    const std::vector<encode::KeyFrame> frames =
        refines ? pool.frames_for(camera.camera.camera_to_world, snapshot) : pool.frames();
    trainer.train(snapshot, frames, config.view_rays, progress);
    bench::look(player::Player(trainer.clip(snapshot)), last, camera, truth.novel_view(camera, number), means);
  }
}

void run_all(const char* path, int count, int seeds) {
  const host::PluginTable plugins = host::PluginTable::builtin();
  Progress progress;
  encode::EncodeOptions options = encode::EncodeOptions::of(encode::Preset::kBalanced);
  const auto capture = ingest::Capture::open(plugins, path, {}, progress);
  const auto truth = evaluate::GroundTruth::read(path);
  if (!truth || truth->novel_cameras().empty()) throw std::runtime_error("it has no pictures of other cameras");
  const Performance performance = perform(*capture, count, options);
  std::printf("| key frames | pool | refined | person dB | object dB | both, box dB |\n");
  std::printf("| --- | --- | --- | --- | --- | --- |\n");
  const std::vector<std::pair<const char*, encode::KeyFrameRule>> rules = {
      {"fixed interval", encode::KeyFrameRule::kInterval},
      {"equations 5 to 7", encode::KeyFrameRule::kPaper},
      {"coverage", encode::KeyFrameRule::kCoverage}};
  for (const std::size_t pool : {10, 20, 100}) {
    for (const auto& [name, rule] : rules) {
      for (const bool refines : {false, true}) {
        std::map<std::string, evaluate::Means> means;
        for (int seed = 0; seed < seeds; ++seed) {
          options.settings.live.key_frames.rule = rule;
          options.settings.live.key_frames.capacity = pool;
          options.settings.fields.trainer.seed = static_cast<std::uint64_t>(seed) * 1000 + 1;
          run(performance, *truth, options, refines, means);
        }
        std::printf("| %s | %zu | %s | %.2f | %.2f | %.2f |\n", name, pool, refines ? "yes" : "no",
                    means["person"].mean("psnr").value_or(0), means["object"].mean("psnr").value_or(0),
                    means["foreground"].mean("psnr_box").value_or(0));
        std::fflush(stdout);
      }
    }
  }
}

} // namespace

int main(int argc, char** argv) {
  if (argc < 2 || argc > 4) {
    std::fprintf(stderr, "usage: bench_key_frames CAPTURE [FRAMES [SEEDS]]\n");
    return 2;
  }
  try {
    run_all(argv[1], argc > 2 ? std::atoi(argv[2]) : 300, argc > 3 ? std::atoi(argv[3]) : 1);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_key_frames: %s\n", error.what());
    return 1;
  }
  return 0;
}
