// Live training with several rules for key frames, sizes of their pool, and with and without refinement for the view
// that is asked for (live_performance.h):
//   bench_key_frames CAPTURE [FRAMES [SEEDS]]        (default: 300 frames, 1 seed)
// Prints means over all looks: PSNR of the person and of the object alone, within their silhouettes, and of both
// together within their box (core/metrics.h).
#include <cstdio>
#include <cstdlib>

#include "host/plugin_table.h"
#include "live_performance.h"

namespace {

using namespace kinora;

void run_all(const char* path, int count, int seeds) {
  const host::PluginTable plugins = host::PluginTable::builtin();
  Progress progress;
  encode::EncodeOptions options = encode::EncodeOptions::of(encode::Preset::kBalanced);
  const auto capture = ingest::Capture::open(plugins, path, {}, progress);
  const auto truth = evaluate::GroundTruth::read(path);
  if (!truth || truth->novel_cameras().empty()) throw std::runtime_error("it has no pictures of other cameras");
  const bench::LivePerformance performance(*capture, count, options);
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
          bench::train_live(performance, *truth, options, refines,
                            [&](const clip::Clip& clip, int frame, const auto& camera, const auto& view) {
                              bench::look(player::Player(clip), frame, camera, view, means);
                            });
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
