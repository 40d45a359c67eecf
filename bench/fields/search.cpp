// How training finds canonical positions in a deforming layer: speed against error, and what it costs a training in
// which no ray was warped before. One thread; times are the thread's own.
//   bench_search CLIP CAPTURE [rays per pixel]     CLIP: what `kinora encode CAPTURE CLIP` wrote
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <optional>

#include "clip/clip_io.h"
#include "core/error.h"
#include "core/parallel.h"
#include "core/random.h"
#include "fields/brute_force.h"
#include "fields/calibration.h"
#include "fields/canonical_search.h"
#include "fields/live_table.h"
#include "fields/proxy_surface.h"
#include "fields/sampling/surface_band.h"
#include "fields/training/trainer.h"
#include "host/plugin_table.h"
#include "ingest/capture/capture.h"
#include "motion/bulk_warp.h"

namespace {

using namespace kinora;
using namespace kinora::bench;
using Eigen::Vector3d;

constexpr std::size_t kRays = 4096; // of a step

double thread_seconds() {
  std::timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// The sample points of a step that looks at one frame.
std::vector<SearchRay> rays_of(const fields::PixelStore& pixels, const fields::StoredFrame& frame, int label,
                               const fields::FieldConfig& config) {
  std::vector<std::size_t> foreground;
  for (std::size_t i = frame.begin; i < frame.end; ++i) {
    if (pixels.pixels()[i].label == label && pixels.pixels()[i].depth.is_measured()) foreground.push_back(i);
  }
  std::vector<SearchRay> rays;
  if (foreground.empty()) return rays;
  Random random(static_cast<std::uint64_t>(frame.frame));
  // As training draws them: neighbours after each other.
  for (std::size_t k = 0; k < kRays; ++k) {
    const fields::StoredPixel& pixel = pixels.pixels()[foreground[k * foreground.size() / kRays]];
    const SE3& camera = frame.camera.camera_to_world;
    SearchRay ray{};
    ray.u = pixel.u;
    ray.v = pixel.v;
    ray.depth = pixel.depth.metres();
    ray.direction = camera.linear() * frame.camera.intrinsics.unproject(pixel.u, pixel.v, 1.0);
    ray.surface = camera.translation() + ray.depth * ray.direction;
    ray.reach = fields::surface_band(config, pixel.depth.metres());
    for (int s = 0; s < kSamples; ++s) {
      ray.behind[static_cast<std::size_t>(s)] = ray.reach * (2 * (s + random.uniform_double()) / kSamples - 1);
    }
    rays.push_back(ray);
  }
  return rays;
}

// What exact means: Newton's method in double precision, with numbers for derivatives.
std::optional<Vector3d> converge(const motion::Warp& warp, const Vector3d& world, Vector3d canonical) {
  for (int step = 0; step < 50; ++step) {
    const auto there = warp.to_world(canonical);
    if (!there) return std::nullopt;
    const Vector3d residual = world - *there;
    if (residual.norm() < 1e-8) return canonical;
    constexpr double kProbe = 1e-5;
    Eigen::Matrix3d derivative;
    for (int a = 0; a < 3; ++a) {
      const auto above = warp.to_world(canonical + kProbe * Vector3d::Unit(a));
      const auto below = warp.to_world(canonical - kProbe * Vector3d::Unit(a));
      if (!above || !below) return std::nullopt;
      derivative.col(a) = (*above - *below) / (2 * kProbe);
    }
    const Vector3d by = derivative.inverse() * residual;
    canonical += by * std::min(1.0, 0.01 / by.norm());
  }
  return std::nullopt;
}

/// Followed along each ray from its surface, where Warp::to_canonical says which part of the surface it is.
Positions exact_positions(const Instant& instant, const std::vector<SearchRay>& rays) {
  constexpr int kSteps = 4;
  Positions positions;
  for (const SearchRay& ray : rays) {
    const auto surface = instant.warp.to_canonical(ray.surface);
    for (const double t : ray.behind) {
      std::optional<Vector3d> position = surface;
      for (int k = 0; position && k <= kSteps; ++k) {
        position = converge(instant.warp, ray.at(t * k / kSteps), *position);
      }
      positions.push_back(position);
    }
  }
  return positions;
}

/// Every node looked at for every sample.
class AllNodes : public CanonicalSearch {
public:
  enum class Method { kByLiveNodes, kExactly };
  explicit AllNodes(Method view_vector) : method_(view_vector) {}

  void prepare(const Instant& instant) override { nodes_.emplace(instant.table->graph(), instant.warp); }
  void find(const std::vector<SearchRay>& rays, Positions& positions) override {
    world_.clear();
    for (const SearchRay& ray : rays) {
      for (const double t : ray.behind) {
        const Eigen::Vector3f p = (ray.at(t) - nodes_->world_origin()).cast<float>();
        world_.push_back({p.x(), p.y(), p.z()});
      }
    }
    canonical_.resize(world_.size());
    if (method_ == Method::kExactly) {
      nodes_->exactly(world_, canonical_.data());
    } else {
      nodes_->by_live_nodes(world_, canonical_.data());
    }
    for (const BruteForce::Point& point : canonical_) {
      const Vector3d position = Eigen::Vector3f(point.data()).cast<double>() + nodes_->canonical_origin();
      positions.push_back(position.allFinite() ? std::optional(position) : std::nullopt);
    }
  }

private:
  Method method_;
  std::optional<BruteForce> nodes_;
  std::vector<BruteForce::Point> world_, canonical_;
};

/// One way back for each ray, turned rigidly about its surface; plain code.
class RigidRay : public CanonicalSearch {
public:
  void prepare(const Instant& instant) override { warp_ = &instant.warp; }
  void find(const std::vector<SearchRay>& rays, Positions& positions) override {
    for (const SearchRay& ray : rays) {
      const auto surface = warp_->to_canonical(ray.surface);
      const Vector3d direction =
          surface ? Vector3d(warp_->at(*surface)->linear().transpose() * ray.direction) : Vector3d::Zero();
      for (const double t : ray.behind) {
        positions.push_back(surface ? std::optional<Vector3d>(*surface + t * direction) : std::nullopt);
      }
    }
  }

private:
  const motion::Warp* warp_ = nullptr;
};

/// What training does: half a parabola on either side of the surface, sixteen rays at a time.
class ParabolicRay : public CanonicalSearch {
public:
  void prepare(const Instant& instant) override { bulk_.emplace(instant.table, instant.warp); }
  void find(const std::vector<SearchRay>& rays, Positions& positions) override {
    world_.clear();
    for (const SearchRay& ray : rays) {
      const Eigen::Vector3f p = (ray.surface - bulk_->world_origin()).cast<float>();
      const Eigen::Vector3f d = ray.direction.cast<float>();
      world_.push_back({{p.x(), p.y(), p.z()}, {d.x(), d.y(), d.z()}, static_cast<float>(ray.reach), 0});
    }
    back_.resize(rays.size());
    bulk_->to_canonical(world_, back_.data());
    const auto vector = [](const std::array<float, 3>& v) { return Eigen::Vector3f(v.data()).cast<double>().eval(); };
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const Vector3d surface = vector(back_[i].point) + bulk_->canonical_origin();
      const Vector3d direction = vector(back_[i].direction);
      for (const double t : rays[i].behind) {
        if (!surface.allFinite()) {
          positions.emplace_back();
        } else {
          positions.emplace_back(surface + t * direction + t * t * vector(back_[i].curvatures[t > 0 ? 1 : 0]));
        }
      }
    }
  }

private:
  std::optional<motion::BulkWarp> bulk_;
  std::vector<motion::BulkWarp::Ray> world_;
  std::vector<motion::BulkWarp::CanonicalRay> back_;
};

struct Measured {
  double milliseconds_per_frame = 0; ///< to prepare
  double milliseconds_per_step = 0;
  std::vector<double> errors; ///< metres, ascending
  std::size_t missing = 0;    ///< samples that have an exact place and got none

  double milliseconds() const { return milliseconds_per_frame + milliseconds_per_step; }
  double quantile_mm(double q) const {
    return 1000 * errors[static_cast<std::size_t>(q * static_cast<double>(errors.size() - 1))];
  }
};

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

Measured measure(const std::vector<Instant>& instants, const std::vector<std::vector<SearchRay>>& steps,
                 const std::vector<Positions>& exact, CanonicalSearch& search) {
  constexpr int kRuns = 5;
  Measured measured;
  std::vector<double> preparing;
  std::vector<double> finding;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    Positions found; // memory is there from the first, unmeasured time on
    double shortest_preparing = 1e9;
    double shortest_finding = 1e9;
    for (int run = 0; run <= kRuns; ++run) {
      found.clear();
      const double begin = thread_seconds();
      search.prepare(instants[i]);
      const double prepared = thread_seconds();
      search.find(steps[i], found);
      if (run == 0) continue;
      shortest_preparing = std::min(shortest_preparing, prepared - begin);
      shortest_finding = std::min(shortest_finding, thread_seconds() - prepared);
    }
    preparing.push_back(shortest_preparing);
    finding.push_back(shortest_finding);
    for (std::size_t k = 0; k < found.size(); ++k) {
      if (!exact[i][k]) continue;
      if (!found[k]) ++measured.missing;
      if (found[k]) measured.errors.push_back((*found[k] - *exact[i][k]).norm());
    }
  }
  measured.milliseconds_per_frame = 1000 * median(preparing);
  measured.milliseconds_per_step = 1000 * median(finding);
  std::sort(measured.errors.begin(), measured.errors.end());
  return measured;
}

void compare_searches(const fields::PixelStore& pixels, const clip::Layer& layer, const fields::FieldConfig& config) {
  double begin = thread_seconds();
  const auto table = std::make_shared<const motion::InfluenceTable>(layer.motion.graph());
  const double table_seconds = thread_seconds() - begin;
  begin = thread_seconds();
  const fields::DrawableField drawable(layer.field, layer.motion.graph().get());
  const double proxy_mesh_seconds = thread_seconds() - begin;
  std::vector<Instant> instants;
  std::vector<std::vector<SearchRay>> steps;
  std::vector<Positions> exact;
  constexpr std::size_t kFrames = 8;
  for (std::size_t k = 0; k < kFrames; ++k) {
    const fields::StoredFrame& frame = pixels.frames()[k * (pixels.frames().size() - 1) / (kFrames - 1)];
    std::vector<SearchRay> rays = rays_of(pixels, frame, layer.label, config);
    if (rays.empty()) continue;
    instants.push_back({layer.motion.warp(frame.frame), table, frame.camera});
    steps.push_back(std::move(rays));
    exact.push_back(exact_positions(instants.back(), steps.back()));
  }
  std::printf("# %zu nodes; a step: %zu rays of one frame, %d samples each; median of %zu frames; what is faster is a "
              "frame with its step\n"
              "# once for a graph: the influence table in %.1f ms, the proxy's mesh in %.1f ms\n",
              layer.motion.graph()->nodes().size(), kRays, kSamples, steps.size(), 1000 * table_seconds,
              1000 * proxy_mesh_seconds);
  std::printf("search,ms_per_frame,ms_per_step,faster_than_live_nodes,faster_than_all_nodes,median_mm,p99_mm,"
              "missing_share\n");
  const auto report = [&](const char* name, CanonicalSearch&& search, const Measured* live, const Measured* all) {
    Measured m = measure(instants, steps, exact, search);
    const auto faster_than = [&](const Measured* other) {
      return other == nullptr ? 1.0 : other->milliseconds() / m.milliseconds();
    };
    std::printf("%s,%.3f,%.3f,%.1f,%.1f,%.4f,%.3f,%.4f\n", name, m.milliseconds_per_frame, m.milliseconds_per_step,
                faster_than(live), faster_than(all), m.quantile_mm(0.5), m.quantile_mm(0.99),
                static_cast<double>(m.missing) / static_cast<double>(m.missing + m.errors.size()));
    std::fflush(stdout);
    return m;
  };
  const Measured all = report("nodes of all", AllNodes(AllNodes::Method::kExactly), nullptr, nullptr);
  const Measured live = report("live nodes of all", AllNodes(AllNodes::Method::kByLiveNodes), nullptr, &all);
  report("proxy surface", ProxySurface(drawable, false), &live, &all);
  report("corrected proxy", ProxySurface(drawable, true), &live, &all);
  report("rigid ray", RigidRay(), &live, &all);
  report("live table", LiveTable(config, layer.field.occupancy), &live, &all);
  report("bent ray", ParabolicRay(), &live, &all);
}

void train(const fields::PixelStore& pixels, const clip::Layer& layer, const fields::FieldConfig& config,
           double rays_per_pixel) {
  const auto foreground =
      std::count_if(pixels.pixels().begin(), pixels.pixels().end(),
                    [&](const fields::StoredPixel& p) { return p.label == layer.label && p.depth.is_known(); });
  fields::TrainerConfig trainer;
  constexpr double kForegroundShare = 0.75; // of the rays; the others tell of emptiness
  trainer.rays = static_cast<std::size_t>(rays_per_pixel * static_cast<double>(foreground) / kForegroundShare);
  Progress progress;
  fields::TrainingReport report;
  const double begin = thread_seconds();
  fields::train_field({pixels, layer.label, layer.motion}, config, trainer, progress, &report);
  const double seconds = thread_seconds() - begin;
  std::printf("rays,seconds,million_rays_per_second,samples_per_ray\n%zu,%.2f,%.3f,%.2f\n", report.rays, seconds,
              static_cast<double>(report.rays) / seconds / 1e6,
              static_cast<double>(report.samples) / static_cast<double>(report.rays));
}

void run(const char* clip_path, const char* capture_path, double rays_per_pixel) {
  print_calibration();
  const clip::Clip clip = clip::read_clip(clip_path);
  const auto layer = std::find_if(clip.layers.begin(), clip.layers.end(), [](const clip::Layer& l) {
    return l.motion.kind() == motion::MotionKind::kDeforming;
  });
  if (layer == clip.layers.end()) throw Error(ErrorCode::kFailure, "the clip has no layer that deforms");
  Progress progress;
  const host::PluginTable plugins = host::PluginTable::builtin();
  const auto capture = ingest::Capture::open(plugins, capture_path, {}, progress);
  fields::PixelStore pixels(24'000'000, clip.times.size());
  for (int i = 0; const auto frame = capture->next(); ++i) {
    if (!clip.held_out[static_cast<std::size_t>(i)]) pixels.add(*frame, i);
  }
  compare_searches(pixels, *layer, layer->field.config);
  train(pixels, *layer, layer->field.config, rays_per_pixel);
}

} // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: bench_search CLIP CAPTURE [rays per pixel]\n");
    return 2;
  }
  try {
    set_thread_count(1);
    run(argv[1], argv[2], argc > 3 ? std::atof(argv[3]) : 1);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_search: %s\n", error.what());
    return 1;
  }
  return 0;
}
