#include "tracking/deforming/block_matching.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include "core/parallel.h"
#include "core/statistics.h"
#include "tracking/rigid/residuals.h"

namespace kinora::tracking {
namespace {

constexpr std::size_t kLevel = 1;
constexpr int kRadius = 4; // of the patch, in its pixels
constexpr int kStride = 2; // of the search at first
constexpr std::size_t kNodesPerChunk = 16;

constexpr int kPatch = (2 * kRadius + 1) * (2 * kRadius + 1);
using Patch = Eigen::Array<float, kPatch, 1>;

struct Pixel {
  int u, v;
};

Pixel pixel_of(const TextureLevel& level, const Eigen::Vector2d& at) {
  return {static_cast<int>(std::lround((at.x() + 0.5) * level.scale - 0.5)),
          static_cast<int>(std::lround((at.y() + 0.5) * level.scale - 0.5))};
}

// The texture about a pixel; nothing at the border.
std::optional<Patch> values_at(const TextureLevel& level, const Pixel& at) {
  if (at.u < kRadius || at.v < kRadius || at.u + kRadius >= level.values.width() ||
      at.v + kRadius >= level.values.height()) {
    return std::nullopt;
  }
  Patch patch;
  Eigen::Index i = 0;
  for (int v = at.v - kRadius; v <= at.v + kRadius; ++v) {
    const float* row = level.values.pixel(at.u - kRadius, v);
    for (int u = 0; u <= 2 * kRadius; ++u) patch[i++] = row[3 * u];
  }
  return patch;
}

bool has_contrast(float squares) {
  return squares >= TextureModel::kMinTextureSigma * TextureModel::kMinTextureSigma * kPatch;
}

// The same with mean zero and length one; nothing without contrast.
std::optional<Patch> patch_at(const TextureLevel& level, const Pixel& at) {
  auto patch = values_at(level, at);
  if (!patch) return std::nullopt;
  *patch -= patch->mean();
  const float squares = patch->matrix().squaredNorm();
  if (!has_contrast(squares)) return std::nullopt;
  *patch /= std::sqrt(squares);
  return patch;
}

// `a`: of mean zero and length one.
double correlation(const Patch& a, const TextureLevel& level, const Pixel& at) {
  auto b = values_at(level, at);
  if (!b) return 0;
  *b -= b->mean();
  const float squares = b->matrix().squaredNorm();
  if (!has_contrast(squares)) return 0;
  return static_cast<double>(a.matrix().dot(b->matrix()) / std::sqrt(squares));
}

// The measured surface at a pixel of the view, well inside the layer.
std::optional<Eigen::Vector3d> surface_at(const LayerView& view, const Eigen::Vector2d& at) {
  const int u = static_cast<int>(std::lround(at.x()));
  const int v = static_cast<int>(std::lround(at.y()));
  if (!view.mask.contains(u, v) || view.mask.at(u, v) != MaskArea::kInterior || view.planes.weights.at(u, v) <= 0)
    return std::nullopt;
  return view.point(u, v);
}

Pixel best_match(const Patch& patch, const TextureLevel& level, const Pixel& centre, int reach, int stride,
                 double& best) {
  Pixel found = centre;
  for (int v = centre.v - reach; v <= centre.v + reach; v += stride) {
    for (int u = centre.u - reach; u <= centre.u + reach; u += stride) {
      const double value = correlation(patch, level, {u, v});
      if (value <= best) continue;
      best = value;
      found = {u, v};
    }
  }
  return found;
}

// What is to be added to where one node is expected, as its own texture has it.
std::optional<Eigen::Vector3d> match(const LayerView& last, const Eigen::Vector3d& then, const LayerView& now,
                                     const Eigen::Vector3d& expected, const BlockMatchingConfig& config) {
  if (!(then.z() > 0) || !(expected.z() > 0)) return std::nullopt;
  const Eigen::Vector2d from = last.intrinsics.project(then);
  const auto surface = surface_at(last, from);
  if (!surface || (*surface - then).norm() > config.surface_distance) return std::nullopt;
  const auto patch = patch_at(last.pyramid[kLevel], pixel_of(last.pyramid[kLevel], from));
  if (!patch) return std::nullopt;
  const TextureLevel& level = now.pyramid[kLevel];
  const Pixel centre = pixel_of(level, now.intrinsics.project(expected));
  const double before = correlation(*patch, level, centre);
  if (before > config.min_correlation) return Eigen::Vector3d(Eigen::Vector3d::Zero());
  double best = before;
  const Pixel coarse = best_match(*patch, level, centre, config.reach, kStride, best);
  const Pixel found = best_match(*patch, level, coarse, kStride - 1, 1, best);
  if (best < config.min_correlation || best < before + config.min_gain) return std::nullopt;
  const Eigen::Vector2d to((found.u + 0.5) / level.scale - 0.5, (found.v + 0.5) / level.scale - 0.5);
  const auto found_surface = surface_at(now, to);
  if (!found_surface) return std::nullopt;
  return Eigen::Vector3d(*found_surface + (then - *surface) - expected);
}

} // namespace

std::vector<Eigen::Vector3d> match_blocks(const LayerView& last, const motion::NodeStates& then, const LayerView& now,
                                          const motion::NodeStates& expected, std::span<const GraphEdge> edges,
                                          const BlockMatchingConfig& config) {
  const std::size_t count = std::min(then.size(), expected.size());
  std::vector<std::optional<Eigen::Vector3d>> matches(count);
  parallel_for(count, kNodesPerChunk, [&](const Chunk& chunk) {
    for (std::size_t n = chunk.begin; n < chunk.end; ++n) {
      matches[n] = match(last, then.positions[n], now, expected.positions[n], config);
    }
  });
  // Most nodes are where they are expected, and all about them are.
  std::vector<std::uint8_t> active(count, 0);
  const auto has_moved = [&](std::size_t n) { return matches[n] && !matches[n]->isZero(0); };
  for (std::size_t n = 0; n < count; ++n) active[n] = has_moved(n) ? 1 : 0;
  for (const GraphEdge& edge : edges) {
    if (has_moved(static_cast<std::size_t>(edge.a))) active[static_cast<std::size_t>(edge.b)] = 1;
    if (has_moved(static_cast<std::size_t>(edge.b))) active[static_cast<std::size_t>(edge.a)] = 1;
  }
  std::vector<std::array<std::vector<double>, 3>> neighbour_matches(count);
  const auto add_neighbour = [&](std::size_t from, std::size_t to) {
    for (std::size_t axis = 0; matches[from] && active[to] != 0 && axis < 3; ++axis) {
      neighbour_matches[to][axis].push_back((*matches[from])[static_cast<Eigen::Index>(axis)]);
    }
  };
  for (std::size_t n = 0; n < count; ++n) add_neighbour(n, n);
  for (const GraphEdge& edge : edges) {
    add_neighbour(static_cast<std::size_t>(edge.a), static_cast<std::size_t>(edge.b));
    add_neighbour(static_cast<std::size_t>(edge.b), static_cast<std::size_t>(edge.a));
  }
  std::vector<Eigen::Vector3d> flow(count, Eigen::Vector3d::Zero());
  for (std::size_t n = 0; n < count; ++n) {
    if (!matches[n] || neighbour_matches[n][0].size() < config.min_matches) continue;
    const Eigen::Vector3d step(median(neighbour_matches[n][0]), median(neighbour_matches[n][1]),
                               median(neighbour_matches[n][2]));
    if (step.norm() > config.min_step) flow[n] = step;
  }
  return flow;
}

} // namespace kinora::tracking
