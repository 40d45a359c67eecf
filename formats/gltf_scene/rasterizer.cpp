#include "gltf_scene/rasterizer.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/linear_light.h"

namespace kinora::formats {
namespace {

constexpr double kNear = 0.01; // metres

/// sRGB codes as linear light.
const std::array<float, 256>& linear_codes() {
  static const std::array<float, 256> codes = [] {
    std::array<float, 256> made{};
    for (std::size_t i = 0; i < made.size(); ++i) made[i] = linear_light(static_cast<float>(i) / 255);
    return made;
  }();
  return codes;
}

std::uint8_t code_of(double light) {
  return static_cast<std::uint8_t>(std::lround(255 * srgb_of_linear(std::clamp(light, 0.0, 1.0))));
}

int wrapped(double place, int size) {
  const auto whole = static_cast<std::int64_t>(std::floor(place));
  return static_cast<int>(((whole % size) + size) % size);
}

/// Linear light of a picture that repeats, between its four nearest pixels.
Eigen::Vector3d sampled(const ColorImage& image, const Eigen::Vector2d& place) {
  const std::array<float, 256>& linear = linear_codes();
  const double u = (place.x() - std::floor(place.x())) * image.width() - 0.5;
  const double v = (place.y() - std::floor(place.y())) * image.height() - 0.5;
  const double fu = u - std::floor(u);
  const double fv = v - std::floor(v);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int k = 0; k < 4; ++k) {
    const int right = k % 2;
    const int below = k / 2;
    const std::uint8_t* pixel = image.pixel(wrapped(u + right, image.width()), wrapped(v + below, image.height()));
    const double weight = (right == 0 ? 1 - fu : fu) * (below == 0 ? 1 - fv : fv);
    for (int c = 0; c < 3; ++c) sum[c] += weight * static_cast<double>(linear[pixel[c]]);
  }
  return sum;
}

/// Twice the area of p, q and (u, v), positive on one side. From q to p it is the same with the other sign, to the bit,
/// so that a pixel on an edge between two triangles belongs to one of them.
double edge(const Eigen::Vector2d& p, const Eigen::Vector2d& q, double u, double v) {
  if (std::pair(q.x(), q.y()) < std::pair(p.x(), p.y())) return -edge(q, p, u, v);
  return (q.x() - p.x()) * (v - p.y()) - (q.y() - p.y()) * (u - p.x());
}

} // namespace

struct Rasterizer::Surface {
  const ColorImage* image; ///< null: none
  std::uint8_t label;
};

Rasterizer::Rasterizer(const Camera& camera)
    : camera_(camera), color_(camera.intrinsics.width, camera.intrinsics.height, 3, 0),
      depth_(camera.intrinsics.width, camera.intrinsics.height, 1, 0),
      labels_(camera.intrinsics.width, camera.intrinsics.height, 1, 0) {}

void Rasterizer::draw(const ScenePrimitive& primitive, const std::vector<Eigen::Vector3f>& vertices,
                      const std::vector<ColorImage>& images, std::uint8_t label) {
  const SE3 to_camera = camera_.camera_to_world.inverse();
  const SceneMaterial& material = primitive.material;
  const bool textured = material.image >= 0 && !primitive.texture_coordinates.empty();
  const Surface surface{textured ? &images[static_cast<std::size_t>(material.image)] : nullptr, label};
  const auto corner = [&](std::uint32_t index) {
    Corner made{to_camera * vertices[index].cast<double>(), Eigen::Vector2d::Zero(), material.base.cast<double>()};
    if (textured) made.texture = primitive.texture_coordinates[index].cast<double>();
    if (!primitive.colors.empty()) made.color = made.color.cwiseProduct(primitive.colors[index].cast<double>());
    return made;
  };
  for (std::size_t i = 0; i + 2 < primitive.indices.size(); i += 3)
    draw_clipped(corner(primitive.indices[i]), corner(primitive.indices[i + 1]), corner(primitive.indices[i + 2]),
                 surface);
}

/// What lies before the near plane; it may be a quadrangle.
void Rasterizer::draw_clipped(const Corner& a, const Corner& b, const Corner& c, const Surface& surface) {
  const std::array<const Corner*, 3> corners{&a, &b, &c};
  if (std::ranges::any_of(corners, [](const Corner* corner) { return !corner->position.allFinite(); })) return;
  std::vector<Corner> kept;
  for (std::size_t i = 0; i < 3; ++i) {
    const Corner& from = *corners[i];
    const Corner& to = *corners[(i + 1) % 3];
    const bool from_inside = from.position.z() >= kNear;
    if (from_inside) kept.push_back(from);
    if (from_inside == (to.position.z() >= kNear)) continue;
    const double share = (kNear - from.position.z()) / (to.position.z() - from.position.z());
    kept.push_back({from.position + share * (to.position - from.position),
                    from.texture + share * (to.texture - from.texture), from.color + share * (to.color - from.color)});
  }
  for (std::size_t i = 2; i < kept.size(); ++i) fill(kept[0], kept[i - 1], kept[i], surface);
}

void Rasterizer::fill(const Corner& a, const Corner& b, const Corner& c, const Surface& surface) {
  const Intrinsics& k = camera_.intrinsics;
  const auto project = [&k](const Corner& corner) {
    const Eigen::Vector3d& p = corner.position;
    return Eigen::Vector2d(k.fx * p.x() / p.z() + k.cx, k.fy * p.y() / p.z() + k.cy);
  };
  const Eigen::Vector2d pa = project(a);
  const Eigen::Vector2d pb = project(b);
  const Eigen::Vector2d pc = project(c);
  const double area = edge(pa, pb, pc.x(), pc.y());
  if (area == 0 || !std::isfinite(area)) return;
  const auto bound = [](double value, int limit) { return static_cast<int>(std::clamp<double>(value, 0, limit)); };
  const int left = bound(std::ceil(std::min({pa.x(), pb.x(), pc.x()})), k.width);
  const int right = bound(std::floor(std::max({pa.x(), pb.x(), pc.x()})) + 1, k.width);
  const int top = bound(std::ceil(std::min({pa.y(), pb.y(), pc.y()})), k.height);
  const int bottom = bound(std::floor(std::max({pa.y(), pb.y(), pc.y()})) + 1, k.height);
  for (int v = top; v < bottom; ++v) {
    for (int u = left; u < right; ++u) {
      const double wa = edge(pb, pc, u, v) / area;
      const double wb = edge(pc, pa, u, v) / area;
      const double wc = edge(pa, pb, u, v) / area;
      if (wa < 0 || wb < 0 || wc < 0) continue;
      const double ia = wa / a.position.z();
      const double ib = wb / b.position.z();
      const double ic = wc / c.position.z();
      const double z = (wa + wb + wc) / (ia + ib + ic);
      float& nearest = depth_.at(u, v);
      if (nearest > 0 && nearest <= static_cast<float>(z)) continue;
      nearest = static_cast<float>(z);
      labels_.at(u, v) = surface.label;
      const double share = 1 / (ia + ib + ic);
      Eigen::Vector3d light = share * (ia * a.color + ib * b.color + ic * c.color);
      if (surface.image != nullptr)
        light = light.cwiseProduct(sampled(*surface.image, share * (ia * a.texture + ib * b.texture + ic * c.texture)));
      std::uint8_t* pixel = color_.pixel(u, v);
      for (int channel = 0; channel < 3; ++channel) pixel[channel] = code_of(light[channel]);
    }
  }
}

} // namespace kinora::formats
