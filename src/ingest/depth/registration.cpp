#include "ingest/depth/registration.h"

#include <atomic>
#include <bit>

#include "core/error.h"
#include "core/parallel.h"
#include "ingest/depth/depth_cleaning.h"

namespace kinora::ingest {
namespace {

constexpr std::size_t kRowsPerChunk = 16;
constexpr float kNothing = std::numeric_limits<float>::infinity();
/// What is an edge is one here as well.
constexpr DepthCleaning kEdges;
/// A triangle of neighbours is never larger than this in colour pixels, unless the cameras do not match.
constexpr float kMaxTriangle = 64;

/// A measurement in the colour camera: pixel coordinates and depth there. `source` is its depth in the depth camera.
struct Vertex {
  float u, v, z;
  float source; ///< 0: no measurement, or behind the colour camera
};

/// A z-buffer that several threads draw into: the least depth does not depend on their order.
class DepthBuffer {
public:
  DepthBuffer(int width, int height) : image_(width, height, 1, kNothing) {}

  void put(int u, int v, float z) {
    // Positive floats are in the order of their bits.
    std::atomic_ref<std::uint32_t> pixel(reinterpret_cast<std::uint32_t&>(image_.at(u, v)));
    const auto bits = std::bit_cast<std::uint32_t>(z);
    std::uint32_t seen = pixel.load(std::memory_order_relaxed);
    while (bits < seen && !pixel.compare_exchange_weak(seen, bits, std::memory_order_relaxed)) {
    }
  }

  void draw(const Vertex& a) {
    const int u = static_cast<int>(std::lround(a.u));
    const int v = static_cast<int>(std::lround(a.v));
    if (image_.contains(u, v)) put(u, v, a.z);
  }

  /// Pixels whose centre lies in the triangle, whichever way round it is.
  void draw(const Vertex& a, const Vertex& b, const Vertex& c) {
    const auto [left, right] = std::minmax({a.u, b.u, c.u});
    const auto [top, bottom] = std::minmax({a.v, b.v, c.v});
    if (!(right - left < kMaxTriangle && bottom - top < kMaxTriangle)) return;
    const float area = (b.u - a.u) * (c.v - a.v) - (b.v - a.v) * (c.u - a.u);
    if (area == 0) return;
    const float per_area = 1 / area;
    const int begin_u = std::max(0, static_cast<int>(std::ceil(left)));
    const int end_u = std::min(image_.width() - 1, static_cast<int>(std::floor(right)));
    const int begin_v = std::max(0, static_cast<int>(std::ceil(top)));
    const int end_v = std::min(image_.height() - 1, static_cast<int>(std::floor(bottom)));
    for (int v = begin_v; v <= end_v; ++v) {
      for (int u = begin_u; u <= end_u; ++u) {
        const float x = static_cast<float>(u) - a.u;
        const float y = static_cast<float>(v) - a.v;
        const float of_b = (x * (c.v - a.v) - y * (c.u - a.u)) * per_area;
        const float of_c = (y * (b.u - a.u) - x * (b.v - a.v)) * per_area;
        if (of_b < 0 || of_c < 0 || of_b + of_c > 1) continue;
        put(u, v, a.z + of_b * (b.z - a.z) + of_c * (c.z - a.z));
      }
    }
  }

  DepthImage take() {
    for (float& z : image_.values())
      if (z == kNothing) z = 0;
    return std::move(image_);
  }

private:
  DepthImage image_;
};

std::vector<Vertex> vertices_of(const DepthImage& depth, const RegistrationGeometry& geometry) {
  std::vector<Vertex> vertices(depth.pixel_count());
  const Intrinsics& from = geometry.depth;
  const Intrinsics& to = geometry.color;
  const Eigen::Matrix3f rotation = geometry.depth_to_color.linear().cast<float>();
  const Eigen::Vector3f translation = geometry.depth_to_color.translation().cast<float>();
  const auto width = static_cast<std::size_t>(depth.width());
  parallel_for(static_cast<std::size_t>(depth.height()), kRowsPerChunk, [&](const Chunk& rows) {
    for (std::size_t v = rows.begin; v < rows.end; ++v) {
      const auto y = static_cast<float>((static_cast<double>(v) - from.cy) / from.fy);
      for (std::size_t u = 0; u < width; ++u) {
        const float z = depth.data()[v * width + u];
        if (!(z > 0)) continue;
        const auto x = static_cast<float>((static_cast<double>(u) - from.cx) / from.fx);
        const Eigen::Vector3f point = rotation * Eigen::Vector3f(x * z, y * z, z) + translation;
        if (!(point.z() > 0)) continue;
        Vertex& vertex = vertices[v * width + u];
        vertex.u = static_cast<float>(to.fx) * point.x() / point.z() + static_cast<float>(to.cx);
        vertex.v = static_cast<float>(to.fy) * point.y() / point.z() + static_cast<float>(to.cy);
        vertex.z = point.z();
        // Far outside the image nothing can be drawn, and pixel numbers must stay numbers.
        const bool near_image = std::abs(vertex.u) < 1e6F && std::abs(vertex.v) < 1e6F;
        vertex.source = near_image ? z : 0;
      }
    }
  });
  return vertices;
}

bool joined(const Vertex& a, const Vertex& b) {
  const float z = std::min(a.source, b.source);
  if (!(z > 0)) return false;
  const float step = std::abs(a.source - b.source);
  return step <= static_cast<float>(kEdges.max_jump) * z ||
         step <= static_cast<float>(kEdges.max_jump_sigmas * kSensorNoise.sigma(z));
}

bool joined(const Vertex& a, const Vertex& b, const Vertex& c) { return joined(a, b) && joined(b, c) && joined(a, c); }

/// The two triangles of four neighbours, or the one that three of them span.
void draw_cell(const Vertex& a, const Vertex& b, const Vertex& c, const Vertex& d, DepthBuffer& buffer) {
  const bool upper = joined(a, b, c);
  const bool lower = joined(b, c, d);
  if (upper) buffer.draw(a, b, c);
  if (lower) buffer.draw(b, d, c);
  if (upper || lower) return;
  if (joined(a, b, d)) buffer.draw(a, b, d);
  if (joined(a, c, d)) buffer.draw(a, d, c);
}

/// True if no triangle can hold this measurement: it has no neighbour in its row, or none in its column.
bool is_isolated(const Vertex* at, std::size_t u, std::size_t v, std::size_t width, std::size_t height) {
  const bool beside = (u > 0 && joined(at[0], *(at - 1))) || (u + 1 < width && joined(at[0], at[1]));
  if (!beside) return true;
  return !(v > 0 && joined(at[0], *(at - width))) && !(v + 1 < height && joined(at[0], at[width]));
}

} // namespace

DepthImage register_depth(const DepthImage& depth, const RegistrationGeometry& geometry) {
  if (depth.width() != geometry.depth.width || depth.height() != geometry.depth.height)
    throw Error(ErrorCode::kUsage, "the depth image does not have the size of the depth camera");
  const std::vector<Vertex> vertices = vertices_of(depth, geometry);
  DepthBuffer buffer(geometry.color.width, geometry.color.height);
  const auto width = static_cast<std::size_t>(depth.width());
  const auto height = static_cast<std::size_t>(depth.height());
  parallel_for(height, kRowsPerChunk, [&](const Chunk& rows) {
    for (std::size_t v = rows.begin; v < rows.end; ++v) {
      for (std::size_t u = 0; u < width; ++u) {
        const Vertex* at = &vertices[v * width + u];
        if (at->source > 0 && is_isolated(at, u, v, width, height)) buffer.draw(*at);
        if (u + 1 < width && v + 1 < height) draw_cell(at[0], at[1], at[width], at[width + 1], buffer);
      }
    }
  });
  return buffer.take();
}

} // namespace kinora::ingest
