// Trains the background of a capture and prints speed against error, as it is before any coding:
//   bench_train_still CAPTURE [million rays] [hold out every N] [levels] [log2 table size] [occupancy resolution]
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>

#include "core/image_codec.h"
#include "core/metrics.h"
#include "fields/network/instruction_set.h"
#include "fields/rendering/renderer.h"
#include "fields/training/trainer.h"
#include "host/plugin_table.h"
#include "ingest/capture/capture.h"

namespace {

using namespace kinora;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

struct Quality {
  double psnr = 0;
  double depth_error = 0; // median, metres
};

Quality quality_of(const fields::Picture& picture, const ingest::Frame& frame) {
  LabelImage measured(frame.depth.width(), frame.depth.height());
  std::vector<float> errors;
  for (std::size_t i = 0; i < measured.pixel_count(); ++i) {
    const bool background = !frame.has_labels() || frame.labels.data()[i] == 0;
    if (frame.depth.data()[i] <= 0 || !background) continue;
    measured.data()[i] = 1;
    errors.push_back(std::abs(frame.depth.data()[i] - picture.depth.data()[i]));
  }
  std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2), errors.end());
  // The metric composites by alpha on black.
  ColorImage shown(measured.width(), measured.height(), 3);
  for (std::size_t i = 0; i < measured.pixel_count(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      shown.data()[3 * i + c] =
          static_cast<std::uint8_t>(picture.color.data()[4 * i + c] * picture.color.data()[4 * i + 3] / 255);
    }
  }
  return {psnr_over(shown, frame.color, measured).value_or(0), errors.empty() ? 0 : errors[errors.size() / 2]};
}

void run(const char* path, double million_rays, int holdout, int levels, int log2_table, int occupancy) {
  Progress progress;
  const host::PluginTable plugins = host::PluginTable::builtin();
  const auto capture = ingest::Capture::open(plugins, path, {}, progress);
  std::vector<ingest::Frame> frames;
  while (auto frame = capture->next()) frames.push_back(std::move(*frame));
  fields::PixelStore store(24'000'000, frames.size());
  const auto held_out = [holdout](std::size_t i) { return holdout > 0 && i % holdout == std::size_t(holdout) - 1; };
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (!held_out(i)) store.add(frames[i], static_cast<int>(i));
  }
  const auto motion = motion::Motion::still();
  fields::FieldConfig config = fields::choose_field_config({store, 0, motion});
  if (levels > 0) config.levels = levels;
  if (log2_table > 0) config.log2_table_size = log2_table;
  if (occupancy > 0) config.occupancy_resolution = occupancy;
  std::printf("%s: box %.2f m, levels %d, finest %d, table 2^%d, %s\n", path, config.box.side, config.levels,
              config.finest_resolution, config.log2_table_size, fields::kernels::instruction_set());
  fields::TrainerConfig trainer;
  trainer.rays = static_cast<std::size_t>(million_rays * 1e6);
  fields::TrainingReport report;
  const std::clock_t cpu_begin = std::clock();
  const fields::DrawableField field(fields::train_field({store, 0, motion}, config, trainer, progress, &report));
  const double cpu_seconds = static_cast<double>(std::clock() - cpu_begin) / CLOCKS_PER_SEC;
  std::printf(
      "training: %.1f s, %.1f s of processors, %.2f M rays/s and core, %.1f samples/ray, loss %.4f, occupied %zu\n",
      report.seconds, cpu_seconds, static_cast<double>(report.rays) / cpu_seconds / 1e6,
      static_cast<double>(report.samples) / static_cast<double>(report.rays), report.final_loss,
      field.field().occupancy.count());
  Quality trained, unseen;
  int trained_count = 0, unseen_count = 0;
  const Clock::time_point begin = Clock::now();
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (!held_out(i) && i % 5 != 0) continue;
    const fields::PosedField posed = fields::pose(field, motion::Warp(SE3::Identity()));
    const fields::Picture picture = fields::render({&posed, 1}, frames[i].camera);
    const Quality q = quality_of(picture, frames[i]);
    Quality& sum = held_out(i) ? unseen : trained;
    sum.psnr += q.psnr;
    sum.depth_error += q.depth_error;
    ++(held_out(i) ? unseen_count : trained_count);
    if (const char* folder = std::getenv("KINORA_BENCH_PICTURES")) {
      const Bytes png = encode_png(picture.color);
      std::FILE* file = std::fopen((std::string(folder) + "/" + std::to_string(i) + ".png").c_str(), "wb");
      std::fwrite(png.data(), 1, png.size(), file);
      std::fclose(file);
    }
  }
  const int count = trained_count + unseen_count;
  std::printf("drawing: %.0f ms per picture\n", 1000 * seconds_since(begin) / count);
  std::printf("trained  %.2f dB, depth %.1f mm (%d frames)\n", trained.psnr / trained_count,
              1000 * trained.depth_error / trained_count, trained_count);
  if (unseen_count > 0) {
    std::printf("held out %.2f dB, depth %.1f mm (%d frames)\n", unseen.psnr / unseen_count,
                1000 * unseen.depth_error / unseen_count, unseen_count);
  }
}

} // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(
        stderr,
        "usage: bench_train_still CAPTURE [million rays] [hold out every N] [levels] [log2 table] [occupancy]\n");
    return 2;
  }
  try {
    const auto number = [&](int i, double otherwise) { return argc > i ? std::atof(argv[i]) : otherwise; };
    run(argv[1], number(2, 20), static_cast<int>(number(3, 10)), static_cast<int>(number(4, 0)),
        static_cast<int>(number(5, 0)), static_cast<int>(number(6, 0)));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_train_still: %s\n", error.what());
    return 1;
  }
  return 0;
}
