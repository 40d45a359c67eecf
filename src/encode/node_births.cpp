#include "encode/node_births.h"

#include <algorithm>
#include <limits>

#include "core/parallel.h"

namespace kinora::encode {
namespace {

constexpr std::uint32_t kNever = std::numeric_limits<std::uint32_t>::max();
constexpr std::uint32_t kStart = 5;           ///< frames from the first pixels on that are the start
constexpr std::size_t kPixelsLookedAt = 1000; ///< of each frame
constexpr double kHangsOn = 0.25;             ///< weight of a node with which surface hangs on it
constexpr int kMinLooks = 3;                  ///< at surface that hangs on a node, in one frame, to have seen it

/// How often a frame shows surface that hangs on each node.
std::vector<int> looks_in(const fields::LayerObservations& observations, const fields::StoredFrame& frame) {
  const fields::PixelStore& pixels = observations.pixels;
  std::vector<std::size_t> own;
  for (std::size_t i = frame.begin; i < frame.end; ++i) {
    const fields::StoredPixel& pixel = pixels.pixels()[i];
    if (observations.is_foreground(pixel) && pixel.depth.is_measured()) own.push_back(i);
  }
  const std::size_t step = 1 + own.size() / kPixelsLookedAt;
  const std::size_t count = (own.size() + step - 1) / step;
  const motion::Warp warp = observations.motion.warp(frame.frame);
  std::vector<motion::Influence> influences(count);
  parallel_for(count, 64, [&](const Chunk& chunk) {
    for (std::size_t k = chunk.begin; k < chunk.end; ++k) {
      const fields::StoredPixel& pixel = pixels.pixels()[own[k * step]];
      const Eigen::Vector3d camera_point = frame.camera.intrinsics.unproject(pixel.u, pixel.v, pixel.depth.metres());
      const auto canonical = warp.to_canonical(frame.camera.camera_to_world * camera_point);
      if (canonical) influences[k] = warp.graph()->influence(*canonical);
    }
  });
  std::vector<int> looks(warp.graph()->nodes().size(), 0);
  for (const motion::Influence& influence : influences) {
    for (std::size_t n = 0; n < static_cast<std::size_t>(influence.count); ++n) {
      if (influence.weights[n] >= kHangsOn) ++looks[static_cast<std::size_t>(influence.nodes[n])];
    }
  }
  return looks;
}

/// The first frame that shows each node; kNever.
std::vector<std::uint32_t> first_shown(const fields::LayerObservations& observations) {
  std::vector<std::uint32_t> shown(observations.motion.graph()->nodes().size(), kNever);
  for (const fields::StoredFrame& frame : observations.pixels.frames()) {
    if (observations.is_lost(frame)) continue;
    const std::vector<int> looks = looks_in(observations, frame);
    for (std::size_t n = 0; n < shown.size(); ++n) {
      if (looks[n] >= kMinLooks) shown[n] = std::min(shown[n], static_cast<std::uint32_t>(frame.frame));
    }
  }
  return shown;
}

} // namespace

motion::NodeBirths node_births(const fields::LayerObservations& observations, double reach) {
  const std::vector<std::uint32_t> shown = first_shown(observations);
  const std::uint32_t start = *std::min_element(shown.begin(), shown.end());
  if (start == kNever) return {};
  const std::vector<Eigen::Vector3d>& nodes = observations.motion.graph()->nodes();
  std::vector<std::uint32_t> births(nodes.size());
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    std::uint32_t birth = kNever;
    std::uint32_t of_nearest = kNever;
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t other = 0; other < nodes.size(); ++other) {
      if (shown[other] == kNever) continue;
      const double distance = (nodes[other] - nodes[n]).norm();
      if (distance <= reach) birth = std::min(birth, shown[other]);
      if (distance < nearest) {
        nearest = distance;
        of_nearest = shown[other];
      }
    }
    births[n] = birth == kNever ? of_nearest : birth;
    if (births[n] <= start + kStart) births[n] = 0;
  }
  return motion::NodeBirths(std::move(births));
}

} // namespace kinora::encode
