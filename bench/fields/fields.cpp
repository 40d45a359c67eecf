// Speed against error of a field's training and drawing in a scene that is known exactly, beside the machine's own
// speed. Prints one line of CSV per training; lines with # are for people:
//   bench_fields [threads=1] [million_rays=2] [noise=0,0.005] [bias=0] [shift=0] [rays_per_step=4096]
//                [surface_samples=0] [free_samples=0] [exact_depth=-1] [levels=0] [log2_table_size=0]
//                [max_log2_table_size=17] [geometry=density] [warm_million_rays=0] [warm_rate=1] [target=avx2]
// Every value but the last may be a list; all combinations are run. target: trains and draws with these instructions
// (bench/instruction_set.h) instead of the best that there are. noise, bias: standard deviation and offset of
// depth, of the scene's size; shift: pixels that depth lies beside colour. 0 levels, samples or table size, and
// exact_depth −1: as the encoder chooses. geometry: density (0) or sdf (1), a signed distance.
// warm_million_rays: taught before by the first half of the views alone; then the rest arrives, and what is timed
// begins.
#include <algorithm>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "core/metrics.h"
#include "core/parallel.h"
#include "fields/analytic_scene.h"
#include "fields/calibration.h"
#include "fields/planning/view_consistency.h"
#include "fields/rendering/renderer.h"
#include "fields/training/trainer.h"
#include "instruction_set.h"
#include "knobs.h"
#include "stopwatch.h"

namespace {

using namespace kinora;

using bench::Knobs;
using bench::Setting;

void train_and_evaluate(const Setting& setting) {
  const auto whole = [&](const char* name) { return static_cast<int>(setting.at(name)); };
  set_thread_count(whole("threads"));
  const bench::AnalyticScene scene{setting.at("noise"), setting.at("bias"), whole("shift")};
  const auto views = [&scene](int count) {
    fields::PixelStore store(4'000'000, static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) store.add(scene.trained_view(i), i);
    return store;
  };
  const fields::PixelStore store = views(bench::AnalyticScene::kTrainedViews);
  const auto motion = motion::Motion::still();
  fields::FieldConfig config = fields::choose_field_config({store, 1, motion});
  if (whole("levels") > 0) config.levels = whole("levels");
  if (whole("log2_table_size") > 0) config.log2_table_size = whole("log2_table_size");
  config.geometry = static_cast<fields::Geometry>(whole("geometry"));
  config.validate("bench_fields");
  fields::TrainerConfig trainer;
  trainer.rays = static_cast<std::size_t>(setting.at("million_rays") * 1e6);
  trainer.rays_per_step = whole("rays_per_step");
  trainer.max_log2_table_size = whole("largest_log2_table_size");
  const fields::ViewConsistency consistency = fields::measure_view_consistency({store, 1, motion});
  fields::adapt_to(consistency, {}, trainer);
  if (whole("surface_samples") > 0) trainer.sampling.surface_samples = whole("surface_samples");
  if (whole("free_samples") > 0) trainer.sampling.free_samples = whole("free_samples");
  if (whole("exact_depth") >= 0) trainer.exact_depth = whole("exact_depth") > 0;
  Progress progress;
  fields::TrainingReport report;
  std::optional<fields::Field> before;
  if (setting.at("warm_million_rays") > 0) {
    fields::TrainerConfig first = trainer;
    first.rays = static_cast<std::size_t>(setting.at("warm_million_rays") * 1e6);
    before = fields::train_field({views(bench::AnalyticScene::kTrainedViews / 2), 1, motion}, config, first, progress);
    trainer.learning_rates.table *= static_cast<float>(setting.at("warm_rate"));
    trainer.learning_rates.nets *= static_cast<float>(setting.at("warm_rate"));
  }
  const bench::Stopwatch watch;
  fields::Field trained =
      fields::train_field({store, 1, motion}, config, trainer, progress, &report, before ? &*before : nullptr);
  const double cpu_seconds = 1e-3 * watch.processor_milliseconds();
  const fields::DrawableField field(std::move(trained));
  double psnr = 0;
  std::vector<float> depth_errors;
  double drawing = 0;
  for (int i = 0; i < bench::AnalyticScene::kHeldOutViews; ++i) {
    const ingest::Frame truth = scene.held_out_view(i);
    const fields::PosedField posed = fields::pose(field, motion::Warp(SE3::Identity()));
    const bench::Stopwatch one;
    const fields::Picture picture = fields::render({&posed, 1}, truth.camera);
    drawing += one.milliseconds();
    psnr += compare_images(picture.color, truth.color).psnr_full;
    for (std::size_t k = 0; k < truth.labels.pixel_count(); ++k) {
      if (truth.labels.data()[k] != 1) continue;
      depth_errors.push_back(std::abs(picture.depth.data()[k] - truth.depth.data()[k]));
    }
  }
  const auto middle = depth_errors.begin() + static_cast<std::ptrdiff_t>(depth_errors.size() / 2);
  std::nth_element(depth_errors.begin(), middle, depth_errors.end());
  for (const auto& [name, value] : setting) std::printf("%g,", value);
  std::printf("%d,%d,", fields::FieldConfig::kHidden, fields::FieldConfig::kColorHidden);
  const auto rays = static_cast<double>(report.rays);
  std::printf("%.2f,%.2f,%.3f,%.2f,%.2f,%.2f,%.1f\n", report.seconds, cpu_seconds,
              rays / report.seconds / whole("threads") / 1e6, static_cast<double>(report.samples) / rays,
              psnr / bench::AnalyticScene::kHeldOutViews, 1000 * static_cast<double>(*middle),
              drawing / bench::AnalyticScene::kHeldOutViews);
  for (const fields::TableGrowthTrial& trial : report.table_growth) {
    std::printf("# after %zu rays: tables of 2^%d full to %.2f; colour error held apart %.5f, with twice the entries "
                "%.5f: %s; %zu rays\n",
                trial.begin, trial.log2_table_size, trial.table_fill, trial.error, trial.grown_error,
                trial.kept ? "kept" : "not kept", trial.discarded_rays);
  }
  std::fflush(stdout);
}

} // namespace

int main(int argc, char** argv) {
  Knobs knobs{{"threads", {1}},
              {"million_rays", {2}},
              {"noise", {0, 0.005}},
              {"rays_per_step", {4096}},
              {"bias", {0}},
              {"shift", {0}},
              {"surface_samples", {0}},
              {"free_samples", {0}},
              {"exact_depth", {-1}},
              {"levels", {0}},
              {"geometry", {0}},
              {"log2_table_size", {0}},
              {"largest_log2_table_size", {17}},
              {"warm_million_rays", {0}},
              {"warm_rate", {1}}};
  try {
    for (int i = 1; i < argc; ++i) {
      if (bench::set_knob(argv[i], knobs, {"density", "sdf"})) continue;
      if (const std::string argument = argv[i]; argument.starts_with("target=")) {
        bench::use_instruction_set(argument.substr(argument.find('=') + 1));
        continue;
      }
      std::fprintf(stderr,
                   "bench_fields: %s: no name=value of a knob; they stand at the top of bench/fields/fields.cpp\n",
                   argv[i]);
      return 2;
    }
    bench::print_calibration();
    for (const auto& [name, values] : knobs) std::printf("%s,", name.c_str());
    std::printf("hidden,color_hidden,seconds,cpu_seconds,million_rays_per_second_and_core,samples_per_ray,held_out_db,"
                "depth_mm,drawing_ms\n");
    bench::run_all(knobs, train_and_evaluate);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_fields: %s\n", error.what());
    return 1;
  }
  return 0;
}
