// Prepares a still camera's capture as if a hand had held the camera (moving_capture.h), without its masks: prints how
// far off the camera is that was found, and the overlap of the labels with the masks; every tenth frame, tinted by
// label, goes into FOLDER:
//   bench_carried CAPTURE [DEGREES [FOLDER]]     (default: 5 degrees to either side; 0: the camera is left still)
// With KINORA_BENCH_POSES set, the capture tells where its camera is.
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>

#include "encode/capture_report.h"
#include "host/plugin_table.h"
#include "label_pictures.h"
#include "moving_capture.h"

namespace {

using namespace kinora;

/// Prints warnings.
class Printing final : public Progress {
public:
  void warn(const std::string& sentence) override { std::printf("warning: %s\n", sentence.c_str()); }
};

double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// Worst and mean distances of found poses from true ones.
struct PathErrors {
  double sum = 0;
  double worst = 0;
  double worst_angle = 0;
  int count = 0;

  void add(const SE3& found, const SE3& truth) {
    const SE3 off = found.inverse() * truth;
    sum += off.translation().norm();
    worst = std::max(worst, off.translation().norm());
    worst_angle = std::max(worst_angle, rotation_angle(off));
    ++count;
  }
};

void run(const char* path, double degrees, const std::filesystem::path& folder) {
  Printing progress;
  const host::PluginTable plugins = host::PluginTable::builtin();
  const bool told = std::getenv("KINORA_BENCH_POSES") != nullptr;
  encode::CaptureRequest request;
  request.open = [&](const ingest::CaptureOptions& how, Progress& to) {
    return std::make_unique<bench::MovingCapture>(ingest::Capture::open(plugins, path, how, to), degrees, told);
  };
  request.options.use_masks = false;
  const double start = processor_seconds();
  const encode::PreparedCapture prepared = encode::prepare_capture(request, progress);
  const double ready = processor_seconds();
  std::printf("camera: %s\n", encode::camera_json(prepared).dump().c_str());
  for (const auto& [label, found] : prepared.capture->info().labels)
    std::printf("%d %s, %s: %s\n", label, found.name.c_str(), found.kind.c_str(), found.why.c_str());
  const auto truth = request.open({}, progress);
  PathErrors errors;
  bench::LabelTally tally;
  double labelling = 0;
  for (;;) {
    const double before = processor_seconds();
    const auto frame = prepared.capture->next();
    labelling += processor_seconds() - before;
    if (!frame) break;
    const auto known = truth->next();
    errors.add(frame->camera.camera_to_world, bench::sway(frame->index, degrees));
    tally.add(frame->labels, known ? known->labels : LabelImage());
    if (!folder.empty() && frame->index % 10 == 0) bench::write_tinted(*frame, folder);
  }
  std::printf("camera error: mean %.1f mm, worst %.1f mm and %.2f degrees\n", 1e3 * errors.sum / errors.count,
              1e3 * errors.worst, errors.worst_angle * 180 / std::numbers::pi);
  tally.print();
  std::printf("processor: %.0f ms per frame to prepare, %.0f ms to read and label\n",
              1e3 * (ready - start) / errors.count, 1e3 * labelling / errors.count);
}

} // namespace

int main(int argc, char** argv) {
  if (argc < 2 || argc > 4) {
    std::fprintf(stderr, "usage: bench_carried CAPTURE [DEGREES [FOLDER]]\n");
    return 2;
  }
  try {
    run(argv[1], argc > 2 ? std::atof(argv[2]) : 5, argc > 3 ? argv[3] : "");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_carried: %s\n", error.what());
    return 1;
  }
  return 0;
}
