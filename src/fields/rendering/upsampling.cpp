#include "fields/rendering/upsampling.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/parallel.h"

namespace kinora::fields {
namespace {

constexpr std::size_t kRowsPerChunk = 16;
constexpr float kEdge = 0.02F; // share of the depth that neighbours on one surface may differ by

/// The two pixels along one axis that a pixel of the larger picture lies between.
struct LinearSample {
  int low, high;
  float share; ///< of `high`
  int nearest() const { return share < 0.5F ? low : high; }
};

std::vector<LinearSample> samples_along(int small, int large) {
  std::vector<LinearSample> samples;
  samples.reserve(static_cast<std::size_t>(large));
  const float scale = static_cast<float>(small) / static_cast<float>(large);
  for (int i = 0; i < large; ++i) {
    const float at = std::clamp((static_cast<float>(i) + 0.5F) * scale - 0.5F, 0.0F, static_cast<float>(small - 1));
    const int low = static_cast<int>(at);
    samples.push_back({low, std::min(low + 1, small - 1), at - static_cast<float>(low)});
  }
  return samples;
}

class Upsampler {
public:
  Upsampler(const Picture& small, Picture& large)
      : small_(small), large_(large), columns_(samples_along(small.color.width(), large.color.width())),
        rows_(samples_along(small.color.height(), large.color.height())) {}

  void fill_row(int v) {
    const LinearSample& y = rows_[static_cast<std::size_t>(v)];
    for (int u = 0; u < large_.color.width(); ++u) {
      const LinearSample& x = columns_[static_cast<std::size_t>(u)];
      write_color(x, y, large_.color.pixel(u, v));
      const int near_u = x.nearest();
      const int near_v = y.nearest();
      large_.front.at(u, v) = small_.front.at(near_u, near_v);
      large_.depth.at(u, v) = depth_at(x, y);
      if (!large_.confidence.empty()) large_.confidence.at(u, v) = small_.confidence.at(near_u, near_v);
      if (!large_.normal.empty()) std::copy_n(small_.normal.pixel(near_u, near_v), 3, large_.normal.pixel(u, v));
    }
  }

private:
  void write_color(const LinearSample& x, const LinearSample& y, std::uint8_t* out) const {
    const std::array<const std::uint8_t*, 4> corners{
        small_.color.pixel(x.low, y.low), small_.color.pixel(x.high, y.low), small_.color.pixel(x.low, y.high),
        small_.color.pixel(x.high, y.high)};
    const std::array<float, 4> shares{(1 - x.share) * (1 - y.share), x.share * (1 - y.share), (1 - x.share) * y.share,
                                      x.share * y.share};
    std::array<float, 3> sum{};
    float alpha = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      const float weight = shares[k] * static_cast<float>(corners[k][3]);
      alpha += weight;
      for (std::size_t c = 0; c < 3; ++c) sum[c] += weight * static_cast<float>(corners[k][c]);
    }
    if (alpha < 0.5F) return;
    for (std::size_t c = 0; c < 3; ++c) out[c] = static_cast<std::uint8_t>(std::lrint(sum[c] / alpha));
    out[3] = static_cast<std::uint8_t>(std::lrint(alpha));
  }

  float depth_at(const LinearSample& x, const LinearSample& y) const {
    const float a = small_.depth.at(x.low, y.low);
    const float b = small_.depth.at(x.high, y.low);
    const float c = small_.depth.at(x.low, y.high);
    const float d = small_.depth.at(x.high, y.high);
    const auto [min_depth, max_depth] = std::minmax({a, b, c, d});
    if (!(max_depth - min_depth < kEdge * min_depth)) return small_.depth.at(x.nearest(), y.nearest());
    const float above = a + x.share * (b - a);
    const float below = c + x.share * (d - c);
    return above + y.share * (below - above);
  }

  const Picture& small_;
  Picture& large_;
  std::vector<LinearSample> columns_, rows_;
};

} // namespace

Picture upsampled(const Picture& small, int width, int height) {
  Picture large{ColorImage(width, height, 4), DepthImage(width, height), LabelImage(width, height)};
  if (!small.normal.empty()) large.normal = Image<float>(width, height, 3);
  if (!small.confidence.empty()) large.confidence = Image<std::uint8_t>(width, height, 1);
  Upsampler upsampler(small, large);
  parallel_for(static_cast<std::size_t>(height), kRowsPerChunk, [&](const Chunk& rows) {
    for (std::size_t v = rows.begin; v < rows.end; ++v) upsampler.fill_row(static_cast<int>(v));
  });
  return large;
}

} // namespace kinora::fields
