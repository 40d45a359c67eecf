#include "tracking/depth_planes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"
#include "ingest/sensor_noise.h"

namespace kinora::tracking {
namespace {

constexpr int kRadius = 2;
constexpr int kSums = 9;
constexpr float kMinNeighbours = 6;
constexpr std::size_t kRowsPerChunk = 64;

// Depth with a border of kRadius invalid pixels, inverse depth, and the gate of each pixel; 0 where not allowed.
struct PaddedDepth {
  int stride;
  std::vector<float> depth;
  std::vector<float> inverse;
  std::vector<float> gate;
};

PaddedDepth pad(const DepthImage& depth, const Intrinsics& intrinsics, const LabelImage& allowed) {
  PaddedDepth padded;
  padded.stride = depth.width() + 2 * kRadius;
  const std::size_t size =
      static_cast<std::size_t>(padded.stride) * static_cast<std::size_t>(depth.height() + 2 * kRadius);
  // Far outside every gate, so that the border and missing pixels drop out of the sums without a branch.
  padded.depth.assign(size, -1e6F);
  padded.inverse.assign(size, 0);
  padded.gate.assign(size, 0);
  const float slope = static_cast<float>(6.0 / intrinsics.fx);
  parallel_for(static_cast<std::size_t>(depth.height()), kRowsPerChunk, [&](const Chunk& rows) {
    for (std::size_t v = rows.begin; v < rows.end; ++v) {
      const float* in = depth.pixel(0, static_cast<int>(v));
      const std::uint8_t* mask = allowed.empty() ? nullptr : allowed.pixel(0, static_cast<int>(v));
      const std::size_t row = (v + kRadius) * static_cast<std::size_t>(padded.stride) + kRadius;
      for (int u = 0; u < depth.width(); ++u) {
        const float z = in[u];
        if (!(z > 0.0F && z < 1e3F) || (mask != nullptr && mask[u] == 0)) continue;
        const std::size_t i = row + static_cast<std::size_t>(u);
        padded.depth[i] = z;
        padded.inverse[i] = 1.0F / z;
        padded.gate[i] = 4.0F * static_cast<float>(ingest::depth_sigma(z)) + slope * z;
      }
    }
  });
  return padded;
}

// Sums over the window, for one row of the image: n, Σdu, Σdv, Σdu², Σdu·dv, Σdv², Σw, Σw·du, Σw·dv of inverse depth w.
using RowSums = std::array<std::vector<float>, kSums>;

/// Pixels of a row, end excluded.
struct Columns {
  int begin, end;
};

// From the first to the last pixel that may have a plane.
Columns used_columns(const float* gate, int width) {
  const auto is_used = [](float g) { return g > 0; };
  const float* begin = std::find_if(gate, gate + width, is_used);
  const float* end = gate + width;
  while (end > begin && !is_used(end[-1])) --end;
  return {static_cast<int>(begin - gate), static_cast<int>(end - gate)};
}

// One row of the window is added at a time, so that its five columns are summed without going through memory.
void sum_row(const PaddedDepth& padded, std::size_t v, const Columns& columns, RowSums& sums) {
  for (std::vector<float>& sum : sums) std::fill(sum.begin() + columns.begin, sum.begin() + columns.end, 0.0F);
  const std::size_t centre = (v + kRadius) * static_cast<std::size_t>(padded.stride) + kRadius;
  const float* z = padded.depth.data() + centre;
  const float* gate = padded.gate.data() + centre;
  float* __restrict n = sums[0].data();
  float* __restrict su = sums[1].data();
  float* __restrict sv = sums[2].data();
  float* __restrict suu = sums[3].data();
  float* __restrict suv = sums[4].data();
  float* __restrict svv = sums[5].data();
  float* __restrict sw = sums[6].data();
  float* __restrict swu = sums[7].data();
  float* __restrict swv = sums[8].data();
  for (int dv = -kRadius; dv <= kRadius; ++dv) {
    const std::ptrdiff_t shift = static_cast<std::ptrdiff_t>(dv) * padded.stride;
    const float* other = z + shift;
    const float* inverse = padded.inverse.data() + centre + shift;
    const float fv = static_cast<float>(dv);
    for (int u = columns.begin; u < columns.end; ++u) {
      float row_n = 0;
      float row_u = 0;
      float row_uu = 0;
      float w_sum = sw[u];
      float wu_sum = swu[u];
      float wv_sum = swv[u];
      for (int du = -kRadius; du <= kRadius; ++du) {
        const float fu = static_cast<float>(du);
        const float m = std::fabs(other[u + du] - z[u]) < gate[u] ? 1.0F : 0.0F;
        const float w = m * inverse[u + du];
        row_n += m;
        row_u += m * fu;
        row_uu += m * (fu * fu);
        w_sum += w;
        wu_sum += w * fu;
        wv_sum += w * fv;
      }
      n[u] += row_n;
      su[u] += row_u;
      sv[u] += row_n * fv;
      suu[u] += row_uu;
      suv[u] += row_u * fv;
      svv[u] += row_n * (fv * fv);
      sw[u] = w_sum;
      swu[u] = wu_sum;
      swv[u] = wv_sum;
    }
  }
}

struct InversePlane {
  float value; ///< inverse depth at the pixel
  float du, dv;
  bool valid;
};

InversePlane solve(const RowSums& s, std::size_t u) {
  const float n = s[0][u];
  if (n < kMinNeighbours) return {0, 0, 0, false};
  const float mean_u = s[1][u] / n;
  const float mean_v = s[2][u] / n;
  const float mean_w = s[6][u] / n;
  const float uu = s[3][u] - n * mean_u * mean_u;
  const float uv = s[4][u] - n * mean_u * mean_v;
  const float vv = s[5][u] - n * mean_v * mean_v;
  const float determinant = uu * vv - uv * uv;
  // Pixels on a line leave the slope across it open.
  if (determinant < 0.05F * (uu + vv) * (uu + vv)) return {0, 0, 0, false};
  const float wu = s[7][u] - n * mean_w * mean_u;
  const float wv = s[8][u] - n * mean_w * mean_v;
  const float du = (vv * wu - uv * wv) / determinant;
  const float dv = (uu * wv - uv * wu) / determinant;
  return {mean_w - du * mean_u - dv * mean_v, du, dv, true};
}

} // namespace

DepthPlanes fit_depth_planes(const DepthImage& depth, const Intrinsics& intrinsics, const LabelImage& allowed) {
  if (!allowed.empty() && !allowed.same_size(depth)) {
    throw Error(ErrorCode::kFailure, "the mask for plane fitting has another size than the depth image");
  }
  DepthPlanes result{Image<float>(depth.width(), depth.height(), 4), Image<float>(depth.width(), depth.height())};
  const PaddedDepth padded = pad(depth, intrinsics, allowed);
  const float reference = static_cast<float>(ingest::depth_sigma(1.0));
  parallel_for(static_cast<std::size_t>(depth.height()), kRowsPerChunk, [&](const Chunk& rows) {
    RowSums sums;
    for (std::vector<float>& sum : sums) sum.resize(static_cast<std::size_t>(depth.width()));
    for (std::size_t v = rows.begin; v < rows.end; ++v) {
      const float* gate = padded.gate.data() + (v + kRadius) * static_cast<std::size_t>(padded.stride) + kRadius;
      const Columns columns = used_columns(gate, depth.width());
      sum_row(padded, v, columns, sums);
      for (int u = columns.begin; u < columns.end; ++u) {
        if (gate[u] == 0.0F) continue;
        const InversePlane fit = solve(sums, static_cast<std::size_t>(u));
        if (!fit.valid || !(fit.value > 0)) continue;
        // Points of the plane satisfy a·X + b·Y + c·Z = 1.
        const float x = static_cast<float>((u - intrinsics.cx) / intrinsics.fx);
        const float y = static_cast<float>((static_cast<double>(v) - intrinsics.cy) / intrinsics.fy);
        const float a = fit.du * static_cast<float>(intrinsics.fx);
        const float b = fit.dv * static_cast<float>(intrinsics.fy);
        const float c = fit.value - a * x - b * y;
        const float scale = 1.0F / std::sqrt(a * a + b * b + c * c);
        float* plane = result.planes.pixel(u, static_cast<int>(v));
        plane[0] = -a * scale;
        plane[1] = -b * scale;
        plane[2] = -c * scale;
        plane[3] = scale;
        const float cosine = fit.value * scale / std::sqrt(x * x + y * y + 1.0F);
        const float ratio = reference / static_cast<float>(ingest::depth_sigma(1.0F / fit.value));
        result.weights.at(u, static_cast<int>(v)) = cosine * ratio * ratio;
      }
    }
  });
  return result;
}

} // namespace kinora::tracking
