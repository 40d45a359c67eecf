#include "renderer.h"

#include <algorithm>
#include <cmath>

namespace kinora::simulator {
namespace {

using Vec = Eigen::Vector3d;

constexpr double kNearest = 0.05;
constexpr int kSamples = 2; ///< to a side of a pixel

std::vector<Vec> vertex_normals(const Surface& surface) {
  std::vector<Vec> normals(surface.vertices.size(), Vec::Zero());
  for (const auto& face : surface.faces) {
    const auto corner = [&](std::size_t i) { return static_cast<std::size_t>(face[i]); };
    const Vec& a = surface.vertices[corner(0)];
    const Vec normal = (surface.vertices[corner(1)] - a).cross(surface.vertices[corner(2)] - a);
    for (std::size_t i = 0; i < 3; ++i) normals[corner(i)] += normal;
  }
  return normals;
}

void rasterize_face(const std::array<Vec, 3>& corners, const Intrinsics& k, std::int32_t surface, std::int32_t face,
                    Hits& hits) {
  std::array<Eigen::Vector2d, 3> at;
  for (std::size_t i = 0; i < 3; ++i) {
    if (corners[i].z() < kNearest) return;
    at[i] = k.project(corners[i]);
  }
  const auto cross = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); };
  const double area = cross(at[1] - at[0], at[2] - at[0]);
  if (std::abs(area) < 1e-12) return;
  const auto bounds = [&](int axis, int size) {
    const auto [least, most] = std::minmax({at[0][axis], at[1][axis], at[2][axis]});
    return std::pair(static_cast<int>(std::clamp(std::ceil(least), 0.0, static_cast<double>(size))),
                     static_cast<int>(std::clamp(std::floor(most), -1.0, size - 1.0)));
  };
  const auto [u0, u1] = bounds(0, k.width);
  const auto [v0, v1] = bounds(1, k.height);
  for (int v = v0; v <= v1; ++v) {
    for (int u = u0; u <= u1; ++u) {
      const Eigen::Vector2d p(u, v);
      const double b1 = cross(p - at[0], at[2] - at[0]) / area;
      const double b2 = cross(at[1] - at[0], p - at[0]) / area;
      const double b0 = 1 - b1 - b2;
      if (b0 < 0 || b1 < 0 || b2 < 0) continue;
      const double inverse = b0 / corners[0].z() + b1 / corners[1].z() + b2 / corners[2].z();
      const auto z = static_cast<float>(1 / inverse);
      if (hits.depth.at(u, v) > 0 && z >= hits.depth.at(u, v)) continue;
      hits.depth.at(u, v) = z;
      hits.surface.at(u, v) = surface;
      hits.face.at(u, v) = face;
      hits.weights.at(u, v, 0) = static_cast<float>(b1 / corners[1].z() / inverse);
      hits.weights.at(u, v, 1) = static_cast<float>(b2 / corners[2].z() / inverse);
    }
  }
}

/// Looks from the lamp at the middle of the scene.
Camera lamp_camera(const Light& light) {
  Camera camera;
  constexpr int kSide = 1024;
  camera.intrinsics = {kSide, kSide, kSide * 0.9, kSide * 0.9, (kSide - 1) / 2.0, (kSide - 1) / 2.0};
  const Vec forward = (Vec(0, 0.9, 0) - light.lamp).normalized();
  const Vec right = Vec::UnitY().cross(forward).normalized() * -1;
  camera.camera_to_world.linear() << right, forward.cross(right), forward;
  camera.camera_to_world.translation() = light.lamp;
  return camera;
}

/// How much of the lamp's light comes there, 0 to 1.
class Shadows {
public:
  Shadows(const std::vector<Surface>& surfaces, const Light& light)
      : camera_(lamp_camera(light)), world_to_lamp_(camera_.camera_to_world.inverse()),
        hits_(rasterize(surfaces, camera_)) {}

  double lit(const Vec& point) const {
    constexpr double kBias = 0.025;
    const Vec seen = world_to_lamp_ * point;
    if (seen.z() < kNearest) return 1;
    const Eigen::Vector2d at = camera_.intrinsics.project(seen);
    int open = 0;
    for (int i = 0; i < 9; ++i) {
      const int u = static_cast<int>(std::lround(at.x())) + 2 * (i % 3 - 1);
      const int v = static_cast<int>(std::lround(at.y())) + 2 * (i / 3 - 1);
      const float z = hits_.depth.contains(u, v) ? hits_.depth.at(u, v) : 0.0F;
      if (z <= 0 || seen.z() < static_cast<double>(z) + kBias) ++open;
    }
    return open / 9.0;
  }

private:
  Camera camera_;
  SE3 world_to_lamp_;
  Hits hits_;
};

} // namespace

Hits rasterize(const std::vector<Surface>& surfaces, const Camera& camera) {
  const Intrinsics& k = camera.intrinsics;
  Hits hits{DepthImage(k.width, k.height), Image<std::int32_t>(k.width, k.height, 1, -1),
            Image<std::int32_t>(k.width, k.height, 1, -1), Image<float>(k.width, k.height, 2)};
  const SE3 world_to_camera = camera.camera_to_world.inverse();
  for (std::size_t s = 0; s < surfaces.size(); ++s) {
    std::vector<Vec> seen;
    seen.reserve(surfaces[s].vertices.size());
    for (const Vec& vertex : surfaces[s].vertices) seen.emplace_back(world_to_camera * vertex);
    for (std::size_t f = 0; f < surfaces[s].faces.size(); ++f) {
      const auto corner = [&](std::size_t i) { return seen[static_cast<std::size_t>(surfaces[s].faces[f][i])]; };
      rasterize_face({corner(0), corner(1), corner(2)}, k, static_cast<std::int32_t>(s), static_cast<std::int32_t>(f),
                     hits);
    }
  }
  return hits;
}

View render(const std::vector<Surface>& surfaces, const Light& light, const Camera& camera) {
  const Intrinsics& k = camera.intrinsics;
  const Hits exact = rasterize(surfaces, camera);
  View view{Image<float>(k.width, k.height, 3), exact.depth, LabelImage(k.width, k.height)};
  for (std::size_t i = 0; i < view.labels.pixel_count(); ++i)
    if (exact.surface.data()[i] >= 0)
      view.labels.data()[i] = surfaces[static_cast<std::size_t>(exact.surface.data()[i])].label;

  const Shadows shadows(surfaces, light);
  std::vector<std::vector<Vec>> normals;
  normals.reserve(surfaces.size());
  for (const Surface& surface : surfaces) normals.push_back(vertex_normals(surface));
  Camera fine = camera;
  fine.intrinsics = k.resized(kSamples * k.width, kSamples * k.height);
  const Hits hits = rasterize(surfaces, fine);
  const Vec eye = camera.camera_to_world.translation();
  for (int v = 0; v < fine.intrinsics.height; ++v) {
    for (int u = 0; u < fine.intrinsics.width; ++u) {
      if (hits.surface.at(u, v) < 0) continue;
      const auto s = static_cast<std::size_t>(hits.surface.at(u, v));
      const Surface& surface = surfaces[s];
      const auto f = static_cast<std::size_t>(hits.face.at(u, v));
      const double b1 = hits.weights.at(u, v, 0);
      const double b2 = hits.weights.at(u, v, 1);
      const auto mixed = [&](const std::vector<Vec>& values) -> Vec {
        const auto value = [&](std::size_t i) -> const Vec& {
          return values[static_cast<std::size_t>(surface.faces[f][i])];
        };
        return (1 - b1 - b2) * value(0) + b1 * value(1) + b2 * value(2);
      };
      const Vec point = mixed(surface.vertices);
      const auto vertex = [&](std::size_t i) -> const Vec& {
        return surface.vertices[static_cast<std::size_t>(surface.faces[f][i])];
      };
      Vec normal = surface.smooth ? mixed(normals[s]) : (vertex(1) - vertex(0)).cross(vertex(2) - vertex(0));
      normal.normalize();
      if (normal.dot(eye - point) < 0) normal = -normal;
      const double facing = std::max(0.0, normal.dot((light.lamp - point).normalized()));
      const Vec arriving = light.ambient * (0.75 + 0.25 * normal.y()) + facing * shadows.lit(point) * light.lamp_colour;
      const Vec seen = surface.colour(mixed(surface.rest), f).cwiseProduct(arriving) / (kSamples * kSamples);
      for (int c = 0; c < 3; ++c) view.light.at(u / kSamples, v / kSamples, c) += static_cast<float>(seen[c]);
    }
  }
  return view;
}

} // namespace kinora::simulator
