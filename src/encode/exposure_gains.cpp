#include "encode/exposure_gains.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/linear_light.h"
#include "core/parallel.h"
#include "core/sensor_noise.h"
#include "core/statistics.h"
#include "fields/sampling/pixel_map.h"

namespace kinora::encode {
namespace {

constexpr std::size_t kSamples = 3000;  // pixels of a frame that are carried into others
constexpr std::size_t kMinPixels = 100; // in common, to tell how two frames differ
constexpr int kDark = 20;               // sRGB; darker is noise
constexpr double kChange = 0.03;        // that is one
constexpr double kPrior = 1e-3;         // weight of no gain, beside 1 for two frames that share all samples
constexpr int kSweeps = 2000;
constexpr double kConverged = 1e-7;

using Logs = std::array<double, 3>; // of gains: red, green, blue

/// How much brighter the second frame is than the first.
struct Pair {
  std::size_t first, second; ///< indices into PixelStore::frames()
  Logs ratios;
  double weight;
};

double log_light(std::uint8_t value) {
  static const std::array<double, 256> table = [] {
    std::array<double, 256> values{};
    for (std::size_t i = 1; i < values.size(); ++i) values[i] = std::log(linear_light(static_cast<double>(i) / 255));
    return values;
  }();
  return table[value];
}

bool is_usable(const fields::StoredPixel& pixel) { return pixel.label == 0 && pixel.depth.is_measured(); }

bool can_tell(std::uint8_t value) { return value >= kDark && value < GainTables::kSaturated; }

/// Carries the background of earlier frames into one.
class Comparison {
public:
  Comparison(const fields::PixelStore& pixels, std::size_t frame)
      : pixels_(pixels), frame_(frame), map_(pixels, pixels.frames()[frame]) {}

  std::optional<Pair> with(std::size_t earlier) const {
    const fields::StoredFrame& from = pixels_.frames()[earlier];
    const fields::StoredFrame& to = pixels_.frames()[frame_];
    const SE3 carried = to.camera.camera_to_world.inverse() * from.camera.camera_to_world;
    const std::size_t stride = std::max<std::size_t>(1, (from.end - from.begin) / kSamples);
    std::array<std::vector<double>, 3> ratios;
    for (std::size_t i = from.begin; i < from.end; i += stride) {
      const fields::StoredPixel& pixel = pixels_.pixels()[i];
      if (!is_usable(pixel)) continue;
      const Eigen::Vector3d there = carried * from.camera.intrinsics.unproject(pixel.u, pixel.v, pixel.depth.metres());
      if (!(there.z() > 0)) continue;
      const Eigen::Vector2d at = to.camera.intrinsics.project(there);
      if (!(at.x() > -0.5 && at.y() > -0.5 && at.x() < to.camera.intrinsics.width &&
            at.y() < to.camera.intrinsics.height))
        continue;
      const fields::StoredPixel* seen =
          map_.at(static_cast<int>(std::lround(at.x())), static_cast<int>(std::lround(at.y())));
      if (seen == nullptr || !is_usable(*seen)) continue;
      const double tolerance = kThreeSigmaOfDifference * kSensorNoise.sigma(there.z());
      if (std::abs(seen->depth.metres() - there.z()) > tolerance) continue;
      for (std::size_t c = 0; c < 3; ++c) {
        if (!can_tell(pixel.color[c]) || !can_tell(seen->color[c])) continue;
        ratios[c].push_back(log_light(seen->color[c]) - log_light(pixel.color[c]));
      }
    }
    Pair pair{earlier, frame_, {}, 0};
    std::size_t fewest = kSamples;
    for (std::size_t c = 0; c < 3; ++c) {
      fewest = std::min(fewest, ratios[c].size());
      if (fewest < kMinPixels) return std::nullopt;
      pair.ratios[c] = median(ratios[c]);
    }
    pair.weight = static_cast<double>(fewest) / kSamples;
    return pair;
  }

private:
  const fields::PixelStore& pixels_;
  std::size_t frame_;
  fields::PixelMap map_;
};

// Each frame with the one before, the one before that, and so on at twice the distance each time.
std::vector<Pair> compared(const fields::PixelStore& pixels) {
  std::vector<std::vector<Pair>> of_frame(pixels.frames().size());
  parallel_for(of_frame.size(), 1, [&](const Chunk& chunk) {
    const Comparison comparison(pixels, chunk.index);
    for (std::size_t distance = 1; distance <= chunk.index; distance *= 2) {
      if (const auto pair = comparison.with(chunk.index - distance)) of_frame[chunk.index].push_back(*pair);
    }
  });
  std::vector<Pair> pairs;
  for (const auto& part : of_frame) pairs.insert(pairs.end(), part.begin(), part.end());
  return pairs;
}

// Least squares by sweeps over the frames (Gauss-Seidel): neighbours far and near tell each its gain.
std::vector<Logs> solved(const std::vector<Pair>& pairs, std::size_t frames) {
  std::vector<std::vector<std::size_t>> of_frame(frames);
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    of_frame[pairs[p].first].push_back(p);
    of_frame[pairs[p].second].push_back(p);
  }
  std::vector<Logs> logs(frames, Logs{});
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    double largest = 0;
    for (std::size_t f = 0; f < frames; ++f) {
      Logs sum{};
      double weights = kPrior;
      for (const std::size_t p : of_frame[f]) {
        const Pair& pair = pairs[p];
        const bool is_second = pair.second == f;
        const Logs& other = logs[is_second ? pair.first : pair.second];
        for (std::size_t c = 0; c < 3; ++c) {
          sum[c] += pair.weight * (other[c] + (is_second ? pair.ratios[c] : -pair.ratios[c]));
        }
        weights += pair.weight;
      }
      for (std::size_t c = 0; c < 3; ++c) {
        largest = std::max(largest, std::abs(sum[c] / weights - logs[f][c]));
        logs[f][c] = sum[c] / weights;
      }
    }
    if (largest < kConverged) break;
  }
  return logs;
}

} // namespace

clip::Exposure measure_exposure(const FramePass& pass) {
  const std::vector<fields::StoredFrame>& frames = pass.pixels.frames();
  const std::vector<Logs> logs = solved(compared(pass.pixels), frames.size());
  Logs mean{};
  for (const Logs& log : logs) {
    for (std::size_t c = 0; c < 3; ++c) mean[c] += log[c] / static_cast<double>(logs.size());
  }
  clip::Exposure exposure;
  bool changes = false;
  for (std::size_t f = 0; f < frames.size(); ++f) {
    ColorGain gain;
    for (std::size_t c = 0; c < 3; ++c) {
      const double log = logs[f][c] - mean[c];
      changes = changes || std::abs(log) > std::log(1 + kChange);
      gain.factors[c] = static_cast<float>(std::exp(log));
    }
    exposure[pass.clip.capture_frames[static_cast<std::size_t>(frames[f].frame)]] = gain;
  }
  return changes ? exposure : clip::Exposure{};
}

void take_out(const clip::Exposure& exposure, FramePass& pass) {
  if (exposure.empty()) return;
  for (std::size_t f = 0; f < pass.pixels.frames().size(); ++f) {
    const int number = pass.clip.capture_frames[static_cast<std::size_t>(pass.pixels.frames()[f].frame)];
    pass.pixels.change_colors(f, GainTables(clip::gain_at(exposure, number).inverse()));
  }
}

} // namespace kinora::encode
