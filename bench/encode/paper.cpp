// The ablation tables of Jiang et al., "Instant-NVR", CVPR 2023 (online human rendering, online object rendering), on a
// synthetic capture that knows what other cameras see; live, as theirs (live_performance.h):
//   bench_paper CAPTURE [FRAMES [SEEDS]]        (default: 300 frames, 1 seed)
// - per-vertex texture: the mean colours of all frames so far on a mesh of the last row's geometry (vertex_colors.h);
// - key frames at a fixed interval; selected; selected and refined for the view that is asked for.
// Prints means over all looks, from the truth's cameras and from the capture's at the same frames: PSNR (dB), SSIM and
// MAE (of 255) over the layer's box, PSNR and SSIM over the full picture, each layer alone on black.
#include <cstdio>
#include <cstdlib>

#include "host/plugin_table.h"
#include "live_performance.h"
#include "vertex_colors.h"

namespace {

using namespace kinora;
using AllMeans = std::map<std::string, evaluate::Means>;

constexpr const char* kMeasures[] = {"psnr_box", "ssim_box", "mae_box", "psnr_full", "ssim_full"};

/// Of one row: over looks from other cameras, and from the capture's.
struct Row {
  AllMeans novel;
  AllMeans captured;
};

/// Depth fusion's picture of what the trainer follows by then.
struct FusedLayer {
  evaluate::Subject subject;
  host::Mesh mesh;
  motion::Motion motion;
};

std::vector<FusedLayer> fuse(const clip::Clip& clip, const bench::LivePerformance& performance, int last) {
  std::vector<std::pair<int, std::shared_ptr<const ingest::Frame>>> frames;
  for (int f = 0; f <= last; f += 3) frames.emplace_back(f, performance.frames[static_cast<std::size_t>(f)]);
  std::vector<FusedLayer> fused;
  for (const evaluate::Subject& subject : evaluate::layer_subjects(player::Player(clip), true)) {
    const auto layer = std::ranges::find(clip.layers, subject.name, &clip::Layer::name);
    if (layer->label == 0) continue;
    auto mesh = bench::fused_mesh(*layer);
    if (!mesh) continue;
    bench::color_vertices(layer->motion, layer->label, frames, *mesh);
    fused.push_back({subject, std::move(*mesh), layer->motion});
  }
  return fused;
}

void compare_fused(const std::vector<FusedLayer>& fused, int last, const ingest::Frame& view, AllMeans& means) {
  const Intrinsics& size = view.camera.intrinsics;
  for (const FusedLayer& layer : fused) {
    fields::Picture picture{ColorImage(size.width, size.height, 4), DepthImage(size.width, size.height),
                            LabelImage(size.width, size.height)};
    bench::draw_mesh(layer.mesh, layer.motion.warp(last), view.camera, picture);
    evaluate::compare(picture, view, layer.subject, means[layer.subject.name]);
  }
}

ingest::Frame as_frame(const evaluate::NovelCamera& camera, const evaluate::NovelView& view) {
  ingest::Frame frame;
  frame.camera = camera.camera;
  frame.color = view.color;
  frame.depth = view.depth;
  frame.labels = view.mask;
  return frame;
}

void compare_drawn(const clip::Clip& clip, int last, const ingest::Frame& view, AllMeans& means) {
  const player::Player player(clip);
  for (const evaluate::Subject& subject : evaluate::layer_subjects(player, true))
    evaluate::compare(player.draw(view.camera, last, subject.layers), view, subject, means[subject.name]);
}

void print(const char* camera, const char* layer, const char* name, const AllMeans& means) {
  const auto found = means.find(layer);
  if (found == means.end()) return;
  std::printf("| %s | %s | %s", camera, layer, name);
  for (const char* measure : kMeasures) std::printf(" | %.3f", found->second.mean(measure).value_or(0));
  std::printf(" |\n");
}

void run(const char* path, int count, int seeds) {
  const host::PluginTable plugins = host::PluginTable::builtin();
  Progress progress;
  encode::EncodeOptions options = encode::EncodeOptions::of(encode::Preset::kBalanced);
  const auto capture = ingest::Capture::open(plugins, path, {}, progress);
  const auto truth = evaluate::GroundTruth::read(path);
  if (!truth || truth->novel_cameras().empty()) throw std::runtime_error("it has no pictures of other cameras");
  const bench::LivePerformance performance(*capture, count, options);
  Row fused;
  std::vector<std::pair<const char*, Row>> rows{{"key frames, fixed interval", {}},
                                                {"key frames selected, not refined", {}},
                                                {"key frames selected, refined", {}}};
  for (int seed = 1; seed <= seeds; ++seed) {
    for (std::size_t r = 0; r < rows.size(); ++r) {
      options.settings.live.key_frames.rule =
          r == 0 ? encode::KeyFrameRule::kInterval : encode::KeyFrameRule::kCoverage;
      options.settings.fields.trainer.seed = static_cast<std::uint64_t>(seed) * 1000;
      const bool is_last = r + 1 == rows.size();
      bench::train_live(
          performance, *truth, options, is_last,
          [&](const clip::Clip& clip, int last, const evaluate::NovelCamera& camera, const evaluate::NovelView& view) {
            const ingest::Frame novel = as_frame(camera, view);
            const ingest::Frame& captured = *performance.frames[static_cast<std::size_t>(last)];
            compare_drawn(clip, last, novel, rows[r].second.novel);
            compare_drawn(clip, last, captured, rows[r].second.captured);
            if (!is_last) return;
            const std::vector<FusedLayer> meshes = fuse(clip, performance, last);
            compare_fused(meshes, last, novel, fused.novel);
            compare_fused(meshes, last, captured, fused.captured);
          });
    }
  }
  rows.insert(rows.begin(), {"per-vertex texture", std::move(fused)});
  std::printf("| seen from | layer | method | PSNR box | SSIM box | MAE box | PSNR full | SSIM full |\n");
  std::printf("| --- | --- | --- | --- | --- | --- | --- | --- |\n");
  for (const char* layer : {"person", "object"}) {
    for (const auto& [name, row] : rows) print("other cameras", layer, name, row.novel);
    for (const auto& [name, row] : rows) print("the capture's", layer, name, row.captured);
  }
}

} // namespace

int main(int argc, char** argv) {
  if (argc < 2 || argc > 4) {
    std::fprintf(stderr, "usage: bench_paper CAPTURE [FRAMES [SEEDS]]\n");
    return 2;
  }
  try {
    run(argv[1], argc > 2 ? std::atoi(argv[2]) : 300, argc > 3 ? std::atoi(argv[3]) : 1);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_paper: %s\n", error.what());
    return 1;
  }
  return 0;
}
