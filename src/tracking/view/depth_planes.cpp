#include "tracking/view/depth_planes.h"

#include <algorithm>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"
#include "tracking/view/depth_plane_rows.h"

namespace kinora::tracking {
namespace {

constexpr std::size_t kRowsPerChunk = 64;

/// Pixels of a row, end excluded.
struct Columns {
  std::size_t begin, end;
};

// From the first to the last pixel that may be used.
Columns used_columns(const LabelImage& allowed, int v, std::size_t width) {
  if (allowed.empty()) return {0, width};
  const std::uint8_t* mask = allowed.pixel(0, v);
  const auto is_used = [](std::uint8_t value) { return value != 0; };
  const std::uint8_t* begin = std::find_if(mask, mask + width, is_used);
  const std::uint8_t* end = mask + width;
  while (end > begin && !is_used(end[-1])) --end;
  return {static_cast<std::size_t>(begin - mask), static_cast<std::size_t>(end - mask)};
}

/// The rows about one after the other of an image, with margins.
class RollingRows {
public:
  RollingRows(const DepthImage& depth, const LabelImage& allowed)
      : depth_image_(depth), allowed_(allowed), width_(static_cast<std::size_t>(depth.width())),
        stride_(width_ + 2 * PlaneRows::kMargin), depth_(PlaneRows::kRows * stride_),
        inverse_(PlaneRows::kRows * stride_) {}

  /// Takes in row `v`; one outside the image has no depth.
  void push(int v) {
    const std::size_t first = slot(v) * stride_;
    std::fill_n(depth_.begin() + static_cast<std::ptrdiff_t>(first), stride_, PlaneRows::kNone);
    std::fill_n(inverse_.begin() + static_cast<std::ptrdiff_t>(first), stride_, 0.0F);
    if (v < 0 || v >= depth_image_.height()) return;
    const Columns columns = used_columns(allowed_, v, width_);
    const float* in = depth_image_.pixel(0, v);
    const std::uint8_t* mask = allowed_.empty() ? nullptr : allowed_.pixel(0, v);
    float* depth = depth_.data() + first + PlaneRows::kMargin;
    float* inverse = inverse_.data() + first + PlaneRows::kMargin;
    for (std::size_t u = columns.begin; u < columns.end; ++u) {
      const float z = in[u];
      if (!(z > 0.0F && z < 1e3F) || (mask != nullptr && mask[u] == 0)) continue;
      depth[u] = z;
      inverse[u] = 1.0F / z;
    }
  }

  /// Those about row `v`, once the last of them has been taken in.
  void fill(int v, PlaneRows& rows) const {
    for (std::size_t i = 0; i < PlaneRows::kRows; ++i) {
      const std::size_t first = slot(v + static_cast<int>(i) - static_cast<int>(PlaneRows::kRadius)) * stride_;
      rows.depth[i] = depth_.data() + first + PlaneRows::kMargin;
      rows.inverse[i] = inverse_.data() + first + PlaneRows::kMargin;
    }
  }

private:
  static std::size_t slot(int v) {
    return (static_cast<std::size_t>(v + static_cast<int>(PlaneRows::kRows))) % PlaneRows::kRows;
  }

  const DepthImage& depth_image_;
  const LabelImage& allowed_;
  std::size_t width_, stride_;
  std::vector<float> depth_, inverse_;
};

} // namespace

DepthPlanes fit_depth_planes(const DepthImage& depth, const Intrinsics& intrinsics, const LabelImage& allowed) {
  if (!allowed.empty() && !allowed.same_size(depth)) {
    throw Error(ErrorCode::kFailure, "the mask for plane fitting has another size than the depth image");
  }
  DepthPlanes result{Image<float>(depth.width(), depth.height(), 4), Image<float>(depth.width(), depth.height())};
  constexpr auto kRadius = static_cast<int>(PlaneRows::kRadius);
  parallel_for(static_cast<std::size_t>(depth.height()), kRowsPerChunk, [&](const Chunk& chunk) {
    RollingRows rolling(depth, allowed);
    PlaneRows rows{};
    rows.fx = static_cast<float>(intrinsics.fx);
    rows.fy = static_cast<float>(intrinsics.fy);
    rows.cx = static_cast<float>(intrinsics.cx);
    const auto first = static_cast<int>(chunk.begin);
    const auto end = static_cast<int>(chunk.end);
    for (int v = first - kRadius; v < first + kRadius; ++v) rolling.push(v);
    for (int v = first; v < end; ++v) {
      rolling.push(v + kRadius);
      rolling.fill(v, rows);
      rows.y = static_cast<float>((v - intrinsics.cy) / intrinsics.fy);
      const Columns columns = used_columns(allowed, v, static_cast<std::size_t>(depth.width()));
      fit_row(rows, columns.begin, columns.end, result.planes.pixel(0, v), result.weights.pixel(0, v));
    }
  });
  return result;
}

} // namespace kinora::tracking
