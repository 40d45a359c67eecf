// Labels a capture without its masks, or with every Nth of them (N > 0), and prints speed and, where it has masks,
// their overlap with the labels; every tenth frame, tinted by label, goes into FOLDER:
//   bench_segmentation CAPTURE [N [FOLDER]]
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "core/image_codec.h"
#include "host/plugin_table.h"
#include "ingest/mask_completion.h"

namespace {

using namespace kinora;
using Clock = std::chrono::steady_clock;

double milliseconds_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

/// Pixels that both have, over pixels that either has; nothing if neither has any.
std::optional<double> overlap(const LabelImage& a, const LabelImage& b, int label) {
  double both = 0;
  double either = 0;
  for (std::size_t i = 0; i < a.pixel_count(); ++i) {
    const bool in_a = a.data()[i] == label;
    const bool in_b = b.data()[i] == label;
    both += in_a && in_b ? 1 : 0;
    either += in_a || in_b ? 1 : 0;
  }
  if (either == 0) return std::nullopt;
  return both / either;
}

// Colour darkened, with a tint for each label but 0.
void write_tinted(const ingest::Frame& frame, const std::filesystem::path& folder) {
  constexpr std::array<std::array<int, 3>, 6> kTints{
      {{0, 0, 120}, {120, 0, 0}, {0, 120, 0}, {120, 120, 0}, {0, 120, 120}, {120, 0, 120}}};
  ColorImage image = frame.color;
  for (std::size_t i = 0; i < frame.labels.pixel_count(); ++i) {
    const int label = frame.labels.data()[i];
    for (std::size_t c = 0; c < 3; ++c) {
      std::uint8_t& value = image.data()[3 * i + c];
      const int tint = label == 0 ? 0 : kTints[static_cast<std::size_t>(label) % kTints.size()][c];
      value = static_cast<std::uint8_t>(value / 2 + tint);
    }
  }
  const Bytes png = encode_png(image);
  char name[32];
  std::snprintf(name, sizeof name, "%06d.png", frame.index);
  std::ofstream(folder / name, std::ios::binary)
      .write(reinterpret_cast<const char*>(png.data()), static_cast<std::streamsize>(png.size()));
}

void run(const char* path, int every, const std::filesystem::path& folder) {
  Progress progress;
  const host::PluginTable plugins = host::PluginTable::builtin();
  const auto open = [&](const ingest::FrameRange& range) {
    ingest::CaptureOptions options;
    options.frames = range;
    return ingest::Capture::open(plugins, path, options, progress);
  };
  const auto segmenter = every > 0 ? ingest::make_mask_completion() : ingest::make_motion_segmenter();
  const Clock::time_point begin = Clock::now();
  segmenter->prepare(open, {}, progress);
  std::printf("first pass: %.0f ms\n", milliseconds_since(begin));
  for (const auto& [label, found] : segmenter->labels())
    std::printf("%d %s, %s: %s\n", label, found.name.c_str(), found.kind.c_str(), found.why.c_str());
  const auto capture = open({});
  std::map<int, std::vector<double>> overlaps;
  double spent = 0;
  int frames = 0;
  while (auto frame = capture->next()) {
    const LabelImage truth = frame->labels;
    const bool given = every > 0 && frame->index % every == 0;
    if (!given) frame->labels = {};
    const Clock::time_point start = Clock::now();
    segmenter->label(*frame);
    spent += milliseconds_since(start);
    if (!folder.empty() && (frames % 10 == 0 || capture->info().frame_count < 10)) write_tinted(*frame, folder);
    ++frames;
    if (truth.empty() || given) continue;
    for (int label = 1; label < 256; ++label)
      if (const auto share = overlap(frame->labels, truth, label)) overlaps[label].push_back(*share);
  }
  std::printf("second pass: %.1f ms per frame (%d frames)\n", spent / frames, frames);
  for (const auto& [label, shares] : overlaps) {
    double sum = 0;
    for (const double share : shares) sum += share;
    std::printf("label %d: IoU %.3f (%zu frames)\n", label, sum / static_cast<double>(shares.size()), shares.size());
  }
}

} // namespace

int main(int argc, char** argv) {
  if (argc < 2 || argc > 4) {
    std::fprintf(stderr, "usage: bench_segmentation CAPTURE [N [FOLDER]]\n");
    return 2;
  }
  try {
    run(argv[1], argc > 2 ? std::atoi(argv[2]) : 0, argc > 3 ? argv[3] : "");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_segmentation: %s\n", error.what());
    return 1;
  }
  return 0;
}
