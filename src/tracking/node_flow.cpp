#include "tracking/node_flow.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>

#include "core/parallel.h"
#include "tracking/statistics.h"

namespace kinora::tracking {
namespace {

constexpr std::size_t kLevel = 1;
constexpr int kRadius = 4;              // of the patch, in its pixels
constexpr int kReach = 12;              // of the search, likewise
constexpr int kStride = 2;              // of the search at first
constexpr double kFound = 0.8;          // correlation of the same texture
constexpr double kGain = 0.15;          // at least, over that where it is expected
constexpr float kLeastContrast = 0.02F; // of the log luminance: less is no texture
constexpr double kBeside = 0.02;        // metres between a node and the surface that shows it
constexpr std::size_t kLeastMatches = 3;
constexpr double kLeastStep = 0.008; // metres: the solver finds less by itself
constexpr std::size_t kNodesPerChunk = 16;

constexpr std::size_t kSide = 2 * kRadius + 1;
constexpr std::size_t kPatch = kSide * kSide;
constexpr std::size_t kTextureChannels = 3;
constexpr float kLeastSquares = kLeastContrast * kLeastContrast * kPatch;
using Patch = std::array<float, kPatch>;

struct Pixel {
  int u, v;
};

Pixel pixel_of(const TextureLevel& level, const Eigen::Vector2d& at) {
  return {static_cast<int>(std::lround((at.x() + 0.5) * level.scale - 0.5)),
          static_cast<int>(std::lround((at.y() + 0.5) * level.scale - 0.5))};
}

bool has_patch(const TextureLevel& level, const Pixel& at) {
  return at.u >= kRadius && at.v >= kRadius && at.u + kRadius < level.values.width() &&
         at.v + kRadius < level.values.height();
}

// The texture about a pixel with mean zero and length one; nothing at the border or without contrast.
std::optional<Patch> patch_at(const TextureLevel& level, const Pixel& at) {
  if (!has_patch(level, at)) return std::nullopt;
  Patch patch;
  float sum = 0;
  std::size_t i = 0;
  for (int v = at.v - kRadius; v <= at.v + kRadius; ++v) {
    for (int u = at.u - kRadius; u <= at.u + kRadius; ++u) sum += patch[i++] = level.values.at(u, v, 0);
  }
  float squares = 0;
  for (float& value : patch) {
    value -= sum / static_cast<float>(kPatch);
    squares += value * value;
  }
  if (squares < kLeastSquares) return std::nullopt;
  for (float& value : patch) value /= std::sqrt(squares);
  return patch;
}

// Of a patch as above with the texture about a pixel; 0 at the border or without contrast. The patch has mean zero:
// what the other's mean is does not matter to their product.
double correlation(const Patch& a, const TextureLevel& level, const Pixel& at) {
  if (!has_patch(level, at)) return 0;
  const float centre = level.values.at(at.u, at.v, 0);
  std::array<float, kSide> sums{}, squares{}, products{}; // of each column: no sum waits for another
  for (std::size_t y = 0; y < kSide; ++y) {
    const float* row = level.values.pixel(at.u - kRadius, at.v - kRadius + static_cast<int>(y));
    for (std::size_t x = 0; x < kSide; ++x) {
      const float value = row[x * kTextureChannels] - centre;
      sums[x] += value;
      squares[x] += value * value;
      products[x] += a[y * kSide + x] * value;
    }
  }
  const auto total = [](const std::array<float, kSide>& of) { return std::accumulate(of.begin(), of.end(), 0.0F); };
  const float sum = total(sums);
  const float contrast = total(squares) - sum * sum / static_cast<float>(kPatch);
  return contrast < kLeastSquares ? 0.0 : static_cast<double>(total(products) / std::sqrt(contrast));
}

// The measured surface at a pixel of the view, well inside the layer.
std::optional<Eigen::Vector3d> surface_at(const ObjectView& view, const Eigen::Vector2d& at) {
  const int u = static_cast<int>(std::lround(at.x()));
  const int v = static_cast<int>(std::lround(at.y()));
  if (!view.mask.contains(u, v) || view.mask.at(u, v) != 2 || view.planes.weights.at(u, v) <= 0) return std::nullopt;
  return view.point(u, v);
}

Pixel best_around(const Patch& patch, const TextureLevel& level, const Pixel& centre, int reach, int stride,
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
std::optional<Eigen::Vector3d> match(const ObjectView& last, const Eigen::Vector3d& then, const ObjectView& now,
                                     const Eigen::Vector3d& expected) {
  if (!(then.z() > 0) || !(expected.z() > 0)) return std::nullopt;
  const Eigen::Vector2d from = last.intrinsics.project(then);
  const auto shown = surface_at(last, from);
  if (!shown || (*shown - then).norm() > kBeside) return std::nullopt;
  const auto patch = patch_at(last.pyramid[kLevel], pixel_of(last.pyramid[kLevel], from));
  if (!patch) return std::nullopt;
  const TextureLevel& level = now.pyramid[kLevel];
  const Pixel centre = pixel_of(level, now.intrinsics.project(expected));
  const double before = correlation(*patch, level, centre);
  if (before > kFound) return Eigen::Vector3d(Eigen::Vector3d::Zero());
  double best = before;
  const Pixel coarse = best_around(*patch, level, centre, kReach, kStride, best);
  const Pixel found = best_around(*patch, level, coarse, kStride - 1, 1, best);
  if (best < kFound || best < before + kGain) return std::nullopt;
  const Eigen::Vector2d to((found.u + 0.5) / level.scale - 0.5, (found.v + 0.5) / level.scale - 0.5);
  const auto shows = surface_at(now, to);
  if (!shows) return std::nullopt;
  return Eigen::Vector3d(*shows + (then - *shown) - expected);
}

} // namespace

std::vector<Eigen::Vector3d> find_node_flow(const ObjectView& last, const NodeStates& then, const ObjectView& now,
                                            const NodeStates& expected, std::span<const GraphEdge> edges) {
  const std::size_t count = std::min(then.size(), expected.size());
  std::vector<std::optional<Eigen::Vector3d>> matches(count);
  parallel_for(count, kNodesPerChunk, [&](const Chunk& chunk) {
    for (std::size_t n = chunk.begin; n < chunk.end; ++n) {
      matches[n] = match(last, then.positions[n], now, expected.positions[n]);
    }
  });
  // Of each node and its neighbours: how many matches there are, and how many say that it has moved.
  struct Tally {
    std::size_t matches = 0;
    std::size_t moved = 0;
    bool may_move() const { // otherwise every median is zero
      const std::size_t middle = matches / 2;
      return matches >= kLeastMatches && (moved > middle || moved >= matches - middle);
    }
  };
  const auto for_each_neighbour = [&](const auto& tell) {
    for (std::size_t n = 0; n < count; ++n) tell(n, n);
    for (const GraphEdge& edge : edges) {
      tell(static_cast<std::size_t>(edge.a), static_cast<std::size_t>(edge.b));
      tell(static_cast<std::size_t>(edge.b), static_cast<std::size_t>(edge.a));
    }
  };
  std::vector<Tally> tallies(count);
  for_each_neighbour([&](std::size_t from, std::size_t to) {
    if (!matches[from]) return;
    ++tallies[to].matches;
    if (!matches[from]->isZero(0)) ++tallies[to].moved;
  });
  std::vector<std::array<std::vector<double>, 3>> around(count);
  for_each_neighbour([&](std::size_t from, std::size_t to) {
    if (!matches[from] || !matches[to] || !tallies[to].may_move()) return;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      around[to][axis].push_back((*matches[from])[static_cast<Eigen::Index>(axis)]);
    }
  });
  std::vector<Eigen::Vector3d> flow(count, Eigen::Vector3d::Zero());
  for (std::size_t n = 0; n < count; ++n) {
    if (around[n][0].empty()) continue;
    const Eigen::Vector3d step(median(around[n][0]), median(around[n][1]), median(around[n][2]));
    if (step.norm() > kLeastStep) flow[n] = step;
  }
  return flow;
}

} // namespace kinora::tracking
