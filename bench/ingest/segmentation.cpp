// Labels a capture without its masks, with every Nth of them (N > 0), or as it comes, without a look ahead, and prints
// speed and, where it has masks, their overlap with the labels; every tenth frame, tinted by label, goes into FOLDER:
//   bench_segmentation CAPTURE [N | live [FOLDER]]
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <string_view>

#include "host/plugin_table.h"
#include "ingest/segmentation/mask_completion.h"
#include "label_pictures.h"

namespace {

using namespace kinora;
using Clock = std::chrono::steady_clock;

double milliseconds_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

/// Keeps the masks aside, so that a segmenter does not see them.
class MasksAside final : public ingest::Capture {
public:
  explicit MasksAside(std::unique_ptr<ingest::Capture> capture) : capture_(std::move(capture)) {}
  const ingest::CaptureInfo& info() const override { return capture_->info(); }
  const std::vector<ingest::SkippedFrame>& skipped() const override { return capture_->skipped(); }
  std::optional<ingest::Frame> next() override {
    auto frame = capture_->next();
    if (frame) masks_[frame->index] = std::exchange(frame->labels, {});
    return frame;
  }
  const LabelImage& mask(int frame) const { return masks_.at(frame); }

private:
  std::unique_ptr<ingest::Capture> capture_;
  std::map<int, LabelImage> masks_;
};

void run_live(const char* path, const std::filesystem::path& folder) {
  Progress progress;
  const host::PluginTable plugins = host::PluginTable::builtin();
  MasksAside given(ingest::Capture::open(plugins, path, {}, progress));
  const auto capture = ingest::live_segmented_capture(given, {1, false}, progress);
  bench::LabelTally tally;
  std::vector<double> spent;
  for (Clock::time_point start = Clock::now(); auto frame = capture->next(); start = Clock::now()) {
    spent.push_back(milliseconds_since(start));
    if (!folder.empty() && frame->index % 10 == 0) bench::write_tinted(*frame, folder);
    tally.add(frame->labels, given.mask(frame->index));
  }
  for (const auto& [label, found] : capture->info().labels)
    std::printf("%d %s, %s: %s\n", label, found.name.c_str(), found.kind.c_str(), found.why.c_str());
  if (spent.empty()) return;
  std::printf("first frame: %.0f ms\n", spent.front());
  std::sort(spent.begin(), spent.end());
  std::printf("reading and labelling: median %.1f ms per frame (%zu frames)\n", spent[spent.size() / 2], spent.size());
  tally.print();
}

void run(const char* path, int every, const std::filesystem::path& folder) {
  Progress progress;
  const host::PluginTable plugins = host::PluginTable::builtin();
  const auto open = [&](const FrameRange& range) {
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
  bench::LabelTally tally;
  double spent = 0;
  int frames = 0;
  while (auto frame = capture->next()) {
    const LabelImage truth = frame->labels;
    const bool given = every > 0 && frame->index % every == 0;
    if (!given) frame->labels = {};
    const Clock::time_point start = Clock::now();
    segmenter->label(*frame);
    spent += milliseconds_since(start);
    if (!folder.empty() && (frames % 10 == 0 || capture->info().frame_count < 10)) bench::write_tinted(*frame, folder);
    ++frames;
    tally.add(frame->labels, given ? LabelImage() : truth);
  }
  std::printf("second pass: %.1f ms per frame (%d frames)\n", spent / frames, frames);
  tally.print();
}

} // namespace

int main(int argc, char** argv) {
  if (argc < 2 || argc > 4) {
    std::fprintf(stderr, "usage: bench_segmentation CAPTURE [N | live [FOLDER]]\n");
    return 2;
  }
  try {
    if (argc > 2 && std::string_view(argv[2]) == "live")
      run_live(argv[1], argc > 3 ? argv[3] : "");
    else
      run(argv[1], argc > 2 ? std::atoi(argv[2]) : 0, argc > 3 ? argv[3] : "");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_segmentation: %s\n", error.what());
    return 1;
  }
  return 0;
}
