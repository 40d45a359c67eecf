// Speed against error of a field's training and drawing in a scene that is known exactly, beside the machine's own
// speed:
//   bench_fields [threads [million rays…]]
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "core/metrics.h"
#include "core/parallel.h"
#include "fields/analytic_scene.h"
#include "fields/calibration.h"
#include "fields/kernels.h"
#include "fields/renderer.h"
#include "fields/trainer.h"

namespace {

using namespace kinora;

void train_and_judge(const bench::AnalyticScene& scene, double million_rays, int threads) {
  fields::PixelStore store(4'000'000, bench::AnalyticScene::kTrainedViews);
  for (int i = 0; i < bench::AnalyticScene::kTrainedViews; ++i) store.add(scene.trained_view(i), i);
  const auto motion = tracking::Motion::still();
  const fields::FieldConfig config = fields::choose_field_config(store, 1, motion);
  fields::TrainerConfig trainer;
  trainer.rays = static_cast<std::size_t>(million_rays * 1e6);
  Progress progress;
  fields::TrainingReport report;
  const fields::DrawableField field(fields::train_field(store, 1, motion, config, trainer, progress, &report));
  double psnr = 0;
  double drawing = 0;
  for (int i = 0; i < bench::AnalyticScene::kHeldOutViews; ++i) {
    const ingest::Frame truth = scene.held_out_view(i);
    const fields::PosedField posed = fields::pose(field, tracking::Warp(SE3::Identity()));
    const auto begin = std::chrono::steady_clock::now();
    const fields::Picture picture = fields::render({&posed, 1}, truth.camera);
    drawing += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    psnr += compare_images(picture.color, truth.color).psnr_full;
  }
  std::printf("%5.2f M rays %6.2f s %5.2f M rays/s and core %4.1f samples/ray  held out %.2f dB  drawing %.0f ms\n",
              million_rays, report.seconds, static_cast<double>(report.rays) / report.seconds / threads / 1e6,
              static_cast<double>(report.samples) / static_cast<double>(report.rays),
              psnr / bench::AnalyticScene::kHeldOutViews, 1000 * drawing / bench::AnalyticScene::kHeldOutViews);
  std::fflush(stdout);
}

} // namespace

int main(int argc, char** argv) {
  const int threads = argc > 1 ? std::atoi(argv[1]) : 1;
  std::vector<double> budgets;
  for (int i = 2; i < argc; ++i) budgets.push_back(std::atof(argv[i]));
  if (budgets.empty()) budgets = {0.5, 1, 2, 4};
  set_thread_count(threads);
  const bench::Calibration machine = bench::calibrate();
  std::printf("one core: %.0f GFLOP/s, %.0f look-ups of 32 bytes in 4 MB per microsecond; %s; %d threads\n",
              machine.fma_gflops, machine.lines_per_us, fields::kernels::instruction_set(), threads);
  for (const double noise : {0.0, 0.005}) {
    std::printf("depth noise %.1f %% of the scene\n", 100 * noise);
    for (const double rays : budgets) train_and_judge({noise}, rays, threads);
  }
  return 0;
}
