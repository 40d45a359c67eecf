// How far the borders of a capture's masks lie beside edges of depth, and with the same capture with its true masks,
// how well both overlap before and after they are laid on edges:
//   bench_mask_borders CAPTURE [TRUE_CAPTURE [FOLDER]]
// Every tenth frame, tinted by label, goes into FOLDER.
#include <chrono>
#include <cstdio>
#include <filesystem>

#include "host/plugin_table.h"
#include "ingest/capture/capture.h"
#include "ingest/frame/label_borders.h"
#include "label_pictures.h"

using namespace kinora;

namespace {

void print(const char* what, std::vector<double>& values) {
  std::sort(values.begin(), values.end());
  if (values.empty()) return;
  std::printf("%s: least %.2f, median %.2f, most %.2f (%zu frames)\n", what, values.front(), values[values.size() / 2],
              values.back(), values.size());
}

} // namespace

int main(int argc, char** argv) {
  if (argc < 2 || argc > 4) {
    std::fprintf(stderr, "usage: bench_mask_borders CAPTURE [TRUE_CAPTURE [FOLDER]]\n");
    return 2;
  }
  try {
    using Clock = std::chrono::steady_clock;
    Progress progress;
    const host::PluginTable plugins = host::PluginTable::builtin();
    const auto capture = ingest::Capture::open(plugins, argv[1], {}, progress);
    const auto with_truth = argc > 2 ? ingest::Capture::open(plugins, argv[2], {}, progress) : nullptr;
    bench::LabelTally before, after;
    std::vector<double> contrasts, offsets, looks, times;
    while (auto frame = capture->next()) {
      if (!frame->has_labels()) continue;
      const Clock::time_point start = Clock::now();
      if (const auto contrast = ingest::border_contrast(frame->labels, frame->color)) contrasts.push_back(*contrast);
      looks.push_back(std::chrono::duration<double, std::milli>(Clock::now() - start).count());
      if (const auto offset = ingest::border_offset(frame->labels, frame->depth)) offsets.push_back(*offset);
      const auto truth = with_truth ? with_truth->next() : std::nullopt;
      if (truth) before.add(frame->labels, truth->labels);
      const Clock::time_point begin = Clock::now();
      ingest::lay_borders_on_edges(*frame);
      times.push_back(std::chrono::duration<double, std::milli>(Clock::now() - begin).count());
      if (truth) after.add(frame->labels, truth->labels);
      if (argc > 3 && frame->index % 10 == 0) bench::write_tinted(*frame, argv[3]);
    }
    print("colour across borders to colour beside them", contrasts);
    print("pixels beside edges of depth", offsets);
    print("ms to look", looks);
    print("ms to lay them on edges", times);
    if (with_truth) {
      std::printf("as given: ");
      before.print();
      std::printf("on edges: ");
      after.print();
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
