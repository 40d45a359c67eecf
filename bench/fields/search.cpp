// How training finds canonical positions in a deforming layer: speed against error, and what it costs a training in
// which no ray was warped before. One thread; times are the thread's own.
//   bench_search CLIP CAPTURE [rays per pixel]     CLIP: what `kinora encode CAPTURE CLIP` wrote
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <optional>

#include "core/error.h"
#include "core/parallel.h"
#include "core/random.h"
#include "encode/clip_io.h"
#include "fields/brute_force.h"
#include "fields/calibration.h"
#include "fields/surface_band.h"
#include "fields/trainer.h"
#include "host/plugin_table.h"
#include "ingest/capture.h"
#include "tracking/bulk_warp.h"

namespace {

using namespace kinora;
using Eigen::Vector3d;
using Places = std::vector<std::optional<Vector3d>>;

constexpr std::size_t kRays = 4096; // of a step
constexpr int kSamples = 8;         // of a ray, spread over the band about its surface

double thread_seconds() {
  std::timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Ray {
  Vector3d surface;
  Vector3d direction;                  ///< for a metre of depth
  double reach;                        ///< half the band, metres of depth
  std::array<double, kSamples> behind; ///< where the samples lie, from the surface

  Vector3d at(double t) const { return surface + t * direction; }
};

/// The sample points of a step that looks at one frame.
std::vector<Ray> rays_of(const fields::PixelStore& pixels, const fields::StoredFrame& frame, int label,
                         const fields::FieldConfig& config) {
  std::vector<std::size_t> own;
  for (std::size_t i = frame.begin; i < frame.end; ++i) {
    if (pixels.pixels()[i].label == label && pixels.pixels()[i].depth > 0) own.push_back(i);
  }
  std::vector<Ray> rays;
  if (own.empty()) return rays;
  Random random(static_cast<std::uint64_t>(frame.frame));
  // As training draws them: neighbours after each other.
  for (std::size_t k = 0; k < kRays; ++k) {
    const fields::StoredPixel& pixel = pixels.pixels()[own[k * own.size() / kRays]];
    const SE3& camera = frame.camera.camera_to_world;
    Ray ray{};
    ray.direction = camera.linear() * frame.camera.intrinsics.unproject(pixel.u, pixel.v, 1.0);
    ray.surface = camera.translation() + pixel.depth * ray.direction;
    ray.reach = fields::surface_band(config, pixel.depth);
    for (int s = 0; s < kSamples; ++s) {
      ray.behind[static_cast<std::size_t>(s)] = ray.reach * (2 * (s + random.uniform_double()) / kSamples - 1);
    }
    rays.push_back(ray);
  }
  return rays;
}

/// The instant of one frame, as each way of searching wants it prepared.
struct Instant {
  tracking::Warp warp;
  std::shared_ptr<const tracking::InfluenceTable> table;
};

// What exact means: Newton's method in double precision, with numbers for derivatives.
std::optional<Vector3d> converge(const tracking::Warp& warp, const Vector3d& world, Vector3d canonical) {
  for (int step = 0; step < 50; ++step) {
    const auto there = warp.to_world(canonical);
    if (!there) return std::nullopt;
    const Vector3d miss = world - *there;
    if (miss.norm() < 1e-8) return canonical;
    constexpr double kProbe = 1e-5;
    Eigen::Matrix3d derivative;
    for (int a = 0; a < 3; ++a) {
      const auto above = warp.to_world(canonical + kProbe * Vector3d::Unit(a));
      const auto below = warp.to_world(canonical - kProbe * Vector3d::Unit(a));
      if (!above || !below) return std::nullopt;
      derivative.col(a) = (*above - *below) / (2 * kProbe);
    }
    const Vector3d by = derivative.inverse() * miss;
    canonical += by * std::min(1.0, 0.01 / by.norm());
  }
  return std::nullopt;
}

/// Followed along each ray from its surface, where Warp::to_canonical says which part of the surface it is.
Places exact_places(const Instant& instant, const std::vector<Ray>& rays) {
  constexpr int kPieces = 4;
  Places places;
  for (const Ray& ray : rays) {
    const auto surface = instant.warp.to_canonical(ray.surface);
    for (const double t : ray.behind) {
      std::optional<Vector3d> place = surface;
      for (int k = 0; place && k <= kPieces; ++k) {
        place = converge(instant.warp, ray.at(t * k / kPieces), *place);
      }
      places.push_back(place);
    }
  }
  return places;
}

/// All samples of the rays, carried back by one of BruteForce's ways.
template <class Carry>
void by_brute_force(const Instant& instant, const std::vector<Ray>& rays, Places& places, const Carry& carry) {
  using Point = bench::BruteForce::Point;
  const bench::BruteForce all(instant.table->graph(), instant.warp);
  static std::vector<Point> world;
  static std::vector<Point> canonical;
  world.clear();
  for (const Ray& ray : rays) {
    for (const double t : ray.behind) {
      const Eigen::Vector3f p = (ray.at(t) - all.world_origin()).cast<float>();
      world.push_back({p.x(), p.y(), p.z()});
    }
  }
  canonical.resize(world.size());
  carry(all, world, canonical.data());
  for (const Point& point : canonical) {
    const Vector3d place = Eigen::Vector3f(point.data()).cast<double>() + all.canonical_origin();
    places.push_back(place.allFinite() ? std::optional(place) : std::nullopt);
  }
}

void by_live_nodes(const Instant& instant, const std::vector<Ray>& rays, Places& places) {
  by_brute_force(instant, rays, places,
                 [](const auto& all, const auto& world, auto* canonical) { all.by_live_nodes(world, canonical); });
}

void by_all_nodes(const Instant& instant, const std::vector<Ray>& rays, Places& places) {
  by_brute_force(instant, rays, places,
                 [](const auto& all, const auto& world, auto* canonical) { all.exactly(world, canonical); });
}

/// The table of the paper: canonical voxels are carried into the live frame; a live voxel keeps the one that lands in
/// it, and the way back is that voxel's.
void by_live_table(const Instant& instant, const std::vector<Ray>& rays, const fields::FieldConfig& config,
                   const fields::Occupancy& occupancy, Places& places) {
  constexpr int kPerCell = 4; // voxels along an occupied cell
  constexpr int kSide = 512;
  const tracking::BulkWarp bulk(instant.table, instant.warp);
  const double voxel = config.box.side / occupancy.resolution() / kPerCell;
  std::vector<std::array<float, 3>> canonical;
  const auto r = static_cast<std::size_t>(occupancy.resolution());
  for (std::size_t cell = 0; cell < r * r * r; ++cell) {
    if (((occupancy.words()[cell / 64] >> (cell % 64)) & 1) == 0) continue;
    const std::size_t x = cell % r;
    const std::size_t y = cell / r % r;
    const std::size_t z = cell / (r * r);
    const Eigen::Array3d at(static_cast<double>(x), static_cast<double>(y), static_cast<double>(z));
    for (int k = 0; k < kPerCell * kPerCell * kPerCell; ++k) {
      const Eigen::Array3d within = Eigen::Array3i(k, k / kPerCell, k / kPerCell / kPerCell)
                                        .unaryExpr([](int i) { return i % kPerCell; })
                                        .cast<double>();
      const Eigen::Vector3f p =
          (config.box.origin - bulk.canonical_origin() + voxel * (kPerCell * at + within + 0.5).matrix()).cast<float>();
      canonical.push_back({p.x(), p.y(), p.z()});
    }
  }
  std::vector<tracking::BulkWarp::Carried> carried(canonical.size());
  bulk.to_world(canonical, carried.data());
  const auto index = [&](const Eigen::Vector3f& live) -> std::optional<std::size_t> {
    const Eigen::Array3f at = live.array() / static_cast<float>(voxel) + kSide / 2.0F;
    if (!(at >= 0).all() || !(at < kSide).all()) return std::nullopt;
    const Eigen::Array3i c = at.cast<int>();
    return (static_cast<std::size_t>(c.z()) * kSide + static_cast<std::size_t>(c.y())) * kSide +
           static_cast<std::size_t>(c.x());
  };
  static std::vector<std::uint32_t> table(std::size_t{kSide} * kSide * kSide);
  std::vector<std::size_t> filled;
  for (std::size_t i = 0; i < carried.size(); ++i) {
    const auto at = index(Eigen::Vector3f(carried[i].point.data()));
    if (!at) continue;
    table[*at] = static_cast<std::uint32_t>(i) + 1;
    filled.push_back(*at);
  }
  for (const Ray& ray : rays) {
    for (const double t : ray.behind) {
      const Eigen::Vector3f point = (ray.at(t) - bulk.world_origin()).cast<float>();
      const auto at = index(point);
      const std::uint32_t number = at ? table[*at] : 0;
      if (number == 0) {
        places.emplace_back();
        continue;
      }
      const auto& there = carried[number - 1];
      const Eigen::Vector3f back =
          Eigen::Quaternionf(there.rotation.data()).conjugate() * (point - Eigen::Vector3f(there.point.data()));
      places.emplace_back((Eigen::Vector3f(canonical[number - 1].data()) + back).cast<double>() +
                          bulk.canonical_origin());
    }
  }
  for (const std::size_t at : filled) table[at] = 0;
}

/// One way back for each ray, turned rigidly about its surface.
void by_rigid_ray(const Instant& instant, const std::vector<Ray>& rays, Places& places) {
  for (const Ray& ray : rays) {
    const auto surface = instant.warp.to_canonical(ray.surface);
    const Vector3d direction =
        surface ? Vector3d(instant.warp.at(*surface)->linear().transpose() * ray.direction) : Vector3d::Zero();
    for (const double t : ray.behind) {
      places.push_back(surface ? std::optional<Vector3d>(*surface + t * direction) : std::nullopt);
    }
  }
}

/// What training does: half a parabola on either side of the surface, sixteen rays at a time.
void by_bent_ray(const Instant& instant, const std::vector<Ray>& rays, Places& places) {
  const tracking::BulkWarp bulk(instant.table, instant.warp);
  std::vector<tracking::BulkWarp::Ray> world;
  for (const Ray& ray : rays) {
    const Eigen::Vector3f p = (ray.surface - bulk.world_origin()).cast<float>();
    const Eigen::Vector3f d = ray.direction.cast<float>();
    world.push_back({{p.x(), p.y(), p.z()}, {d.x(), d.y(), d.z()}, static_cast<float>(ray.reach), 0});
  }
  std::vector<tracking::BulkWarp::CanonicalRay> back(rays.size());
  bulk.to_canonical(world, back.data());
  const auto vector = [](const std::array<float, 3>& v) { return Eigen::Vector3f(v.data()).cast<double>().eval(); };
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Vector3d surface = vector(back[i].point) + bulk.canonical_origin();
    const Vector3d direction = vector(back[i].direction);
    for (const double t : rays[i].behind) {
      if (!surface.allFinite()) {
        places.emplace_back();
      } else {
        places.emplace_back(surface + t * direction + t * t * vector(back[i].bends[t > 0 ? 1 : 0]));
      }
    }
  }
}

struct Measured {
  double milliseconds = 0; ///< per step
  std::vector<double> errors;
  std::size_t missing = 0; ///< samples that have an exact place and got none
};

template <class Method>
Measured measure(const std::vector<Instant>& instants, const std::vector<std::vector<Ray>>& steps,
                 const std::vector<Places>& exact, const Method& method) {
  constexpr int kRuns = 5;
  Measured measured;
  std::vector<double> times;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    Places found; // its memory is there from the first, unmeasured time on
    double best = 1e9;
    for (int run = 0; run <= kRuns; ++run) {
      found.clear();
      const double begin = thread_seconds();
      method(instants[i], steps[i], found);
      if (run > 0) best = std::min(best, thread_seconds() - begin);
    }
    times.push_back(best);
    for (std::size_t k = 0; k < found.size(); ++k) {
      if (!exact[i][k]) continue;
      if (!found[k]) ++measured.missing;
      if (found[k]) measured.errors.push_back((*found[k] - *exact[i][k]).norm());
    }
  }
  std::sort(times.begin(), times.end());
  measured.milliseconds = 1000 * times[times.size() / 2];
  std::sort(measured.errors.begin(), measured.errors.end());
  return measured;
}

void compare_searches(const fields::PixelStore& pixels, const encode::Layer& layer, const fields::FieldConfig& config) {
  const auto table = std::make_shared<const tracking::InfluenceTable>(layer.motion.graph());
  std::vector<Instant> instants;
  std::vector<std::vector<Ray>> steps;
  std::vector<Places> exact;
  constexpr std::size_t kFrames = 8;
  for (std::size_t k = 0; k < kFrames; ++k) {
    const fields::StoredFrame& frame = pixels.frames()[k * (pixels.frames().size() - 1) / (kFrames - 1)];
    std::vector<Ray> rays = rays_of(pixels, frame, layer.label, config);
    if (rays.empty()) continue;
    instants.push_back({layer.motion.warp(frame.frame), table});
    steps.push_back(std::move(rays));
    exact.push_back(exact_places(instants.back(), steps.back()));
  }
  std::printf("# %zu nodes; a step: %zu rays of a frame, %d samples each; median of %zu frames\n",
              layer.motion.graph()->nodes().size(), kRays, kSamples, steps.size());
  std::printf("search,ms_per_step,faster_than_live_nodes,faster_than_all_nodes,median_mm,p99_mm,missing_share\n");
  double live_nodes = 0;
  double all_nodes = 0;
  const auto report = [&](const char* name, const Measured& m, double* reference) {
    if (reference != nullptr) *reference = m.milliseconds;
    const auto quantile = [&](double q) {
      return 1000 * m.errors[static_cast<std::size_t>(q * static_cast<double>(m.errors.size() - 1))];
    };
    std::printf("%s,%.3f,%.1f,%.1f,%.4f,%.3f,%.4f\n", name, m.milliseconds, live_nodes / m.milliseconds,
                all_nodes / m.milliseconds, quantile(0.5), quantile(0.99),
                static_cast<double>(m.missing) / static_cast<double>(m.missing + m.errors.size()));
    std::fflush(stdout);
  };
  report("live nodes of all", measure(instants, steps, exact, by_live_nodes), &live_nodes);
  report("nodes of all", measure(instants, steps, exact, by_all_nodes), &all_nodes);
  report("live table",
         measure(instants, steps, exact,
                 [&](const Instant& instant, const std::vector<Ray>& rays, Places& places) {
                   by_live_table(instant, rays, config, layer.field.occupancy, places);
                 }),
         nullptr);
  report("rigid ray", measure(instants, steps, exact, by_rigid_ray), nullptr);
  report("bent ray", measure(instants, steps, exact, by_bent_ray), nullptr);
}

void train(const fields::PixelStore& pixels, const encode::Layer& layer, const fields::FieldConfig& config,
           double rays_per_pixel) {
  const auto own = std::count_if(pixels.pixels().begin(), pixels.pixels().end(),
                                 [&](const fields::StoredPixel& p) { return p.label == layer.label && p.depth != 0; });
  fields::TrainerConfig trainer;
  constexpr double kOwnShare = 0.75; // of the rays; the others tell of emptiness
  trainer.rays = static_cast<std::size_t>(rays_per_pixel * static_cast<double>(own) / kOwnShare);
  Progress progress;
  fields::TrainingReport report;
  const double begin = thread_seconds();
  fields::train_field(pixels, layer.label, layer.motion, config, trainer, progress, &report);
  const double seconds = thread_seconds() - begin;
  std::printf("rays,seconds,million_rays_per_second,samples_per_ray\n%zu,%.2f,%.3f,%.2f\n", report.rays, seconds,
              static_cast<double>(report.rays) / seconds / 1e6,
              static_cast<double>(report.samples) / static_cast<double>(report.rays));
}

void run(const char* clip_path, const char* capture_path, double rays_per_pixel) {
  bench::print_calibration();
  const encode::Clip clip = encode::read_clip(clip_path);
  const auto layer = std::find_if(clip.layers.begin(), clip.layers.end(), [](const encode::Layer& l) {
    return l.motion.kind() == tracking::MotionKind::kDeforming;
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
