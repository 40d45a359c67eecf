#include "tracking/solver/point_association.h"

#include <cmath>

#include "core/random.h"
#include "core/sensor_noise.h"
#include "support/every_instruction_set.h"

namespace kinora::tracking {
namespace {

constexpr double kGate = 0.06;
constexpr double kShare = 0.5;

/// A disc of the label before a wall, with holes and with something before it.
LayerView disc_view(Random& random) {
  LayerView view;
  view.intrinsics = {64, 48, 90, 85, 31, 26};
  view.depth = DepthImage(64, 48, 1, 4.0F);
  view.mask = LabelImage(64, 48);
  view.planes.planes = Image<float>(64, 48, 4);
  view.planes.weights = Image<float>(64, 48);
  Image<float> texture(64, 48);
  for (int v = 0; v < 48; ++v) {
    for (int u = 0; u < 64; ++u) {
      texture.at(u, v) = random.uniform();
      const double radius = std::hypot(u - 30, v - 25);
      if (radius > 18) continue;
      view.mask.at(u, v) = radius > 16 ? 1 : 2;
      view.depth.at(u, v) = 2;
      if (random.uniform() < 0.1F) continue;
      const Eigen::Vector3d normal = Eigen::Vector3d(0.3 * random.normal(), 0.3 * random.normal(), -1).normalized();
      const Eigen::Vector3d point = view.intrinsics.unproject(u, v, 2 + 0.02 * random.normal());
      float* plane = view.planes.planes.pixel(u, v);
      for (int i = 0; i < 3; ++i) plane[i] = static_cast<float>(normal[i]);
      plane[3] = static_cast<float>(-normal.dot(point));
      view.planes.weights.at(u, v) = 1;
    }
  }
  for (int v = 0; v < 48; ++v) {
    for (int u = 8; u < 14; ++u) view.depth.at(u, v) = 1;
  }
  view.pyramid = texture_pyramid(texture, 1);
  view.to_silhouette = offsets_to_silhouette(view.mask);
  return view;
}

struct Plain {
  DataTerm terms;
  float image = NAN;
};

Plain plain_association(const motion::PosedPoint& point, const LayerView& view, int level) {
  Plain result;
  const Eigen::Vector3d position = point.position.cast<double>();
  const Eigen::Vector3d normal = point.normal.cast<double>();
  if (!(position.z() > 0.05)) return result;
  const Eigen::Vector2d pixel = view.intrinsics.project(position);
  if (!(pixel.x() > -0.49 && pixel.y() > -0.49 && pixel.x() < view.intrinsics.width - 0.51 &&
        pixel.y() < view.intrinsics.height - 0.51)) {
    return result;
  }
  const int u = static_cast<int>(std::lround(pixel.x()));
  const int v = static_cast<int>(std::lround(pixel.y()));
  const float front = view.depth.at(u, v);
  const bool covered = front > 0 && front < position.z() - std::max(0.03, 3 * kSensorNoise.sigma(position.z()));
  if (view.mask.at(u, v) == 0) {
    const std::int16_t* offset = view.to_silhouette.pixel(u, v);
    const Eigen::Vector2d inwards(offset[0], offset[1]);
    if (inwards.norm() < 1 || covered) return result;
    result.terms.violates_free_space = true;
    const Eigen::Vector2d outwards = -inwards.normalized();
    const Eigen::Vector2d contour =
        Eigen::Vector2d(u - view.intrinsics.cx, v - view.intrinsics.cy) + inwards + outwards;
    const Eigen::Vector3d through =
        Eigen::Vector3d(outwards.x() * view.intrinsics.fx, outwards.y() * view.intrinsics.fy, -outwards.dot(contour))
            .normalized();
    const double distance = through.dot(position);
    if (!(distance > 0) || distance > kGate) return result;
    result.terms.plane_normal = through.cast<float>();
    result.terms.plane_scale = static_cast<float>(std::sqrt(kShare) * view.intrinsics.fx / position.z());
    return result;
  }
  if (normal.dot(position) > -0.17 * position.norm()) return result;
  const bool measured = view.planes.weights.at(u, v) > 0;
  if (measured) {
    const Eigen::Vector3d there = view.point(u, v);
    const Eigen::Vector3d plane = Eigen::Map<const Eigen::Vector3f>(view.planes.planes.pixel(u, v)).cast<double>();
    if ((position - there).norm() <= kGate && normal.dot(plane) >= 0.7) {
      result.terms.plane_normal = plane.cast<float>();
      result.terms.plane_offset = static_cast<float>(-plane.dot(there));
      result.terms.plane_scale = static_cast<float>(
          1 / (kSensorNoise.sigma(there.z()) * std::max(0.3, std::abs(plane.dot(there)) / there.norm())));
      result.terms.on_surface = true;
    }
  }
  const bool contradicted = measured && !result.terms.on_surface;
  result.terms.violates_free_space = contradicted && !covered;
  if (!contradicted && view.mask.at(u, v) == 2 && !covered) {
    result.image = view.sample_texture(level, pixel.x(), pixel.y()).value;
  }
  return result;
}

class PointAssociationTest : public OnEveryInstructionSet {};

TEST_P(PointAssociationTest, IsThatOfAPlainLoop) {
  Random random(8);
  const LayerView view = disc_view(random);
  std::vector<motion::PosedPoint> points(3003);
  for (motion::PosedPoint& point : points) {
    const Eigen::Vector3d position = view.intrinsics.unproject(
        80 * random.uniform_double() - 8, 60 * random.uniform_double() - 6, 2 + 0.06 * random.normal());
    point.position = position.cast<float>();
    const Eigen::Vector3d normal(0.4 * random.normal(), 0.4 * random.normal(), random.uniform() < 0.2F ? 1 : -1);
    point.normal = normal.normalized().cast<float>();
  }
  points[5].position.z() = -2;
  std::vector<DataTerm> terms(points.size());
  std::vector<float> image(points.size());
  for (const int level : {0, 2}) {
    associate_points(points, view, level, {kGate, kGate, kShare}, terms, image);
    int on_surface = 0;
    int on_contour = 0;
    int shown = 0;
    for (std::size_t p = 0; p < points.size(); ++p) {
      const Plain plain = plain_association(points[p], view, level);
      EXPECT_EQ(terms[p].on_surface, plain.terms.on_surface) << p;
      EXPECT_EQ(terms[p].violates_free_space, plain.terms.violates_free_space) << p;
      EXPECT_LT((terms[p].plane_normal - plain.terms.plane_normal).norm(), 1e-5F) << p;
      EXPECT_NEAR(terms[p].plane_offset, plain.terms.plane_offset, 1e-5) << p;
      EXPECT_NEAR(terms[p].plane_scale, plain.terms.plane_scale, 1e-4 * plain.terms.plane_scale) << p;
      ASSERT_EQ(std::isnan(image[p]), std::isnan(plain.image)) << p;
      if (!std::isnan(image[p])) {
        EXPECT_NEAR(image[p], plain.image, 1e-4) << p;
      }
      on_surface += plain.terms.on_surface ? 1 : 0;
      on_contour += !plain.terms.on_surface && plain.terms.plane_scale > 0 ? 1 : 0;
      shown += std::isnan(plain.image) ? 0 : 1;
    }
    EXPECT_GT(on_surface, 200);
    EXPECT_GT(on_contour, 20);
    EXPECT_GT(shown, 100);
  }
}

TEST_P(PointAssociationTest, TexturesAreThoseOfAPlainLoop) {
  Random random(8);
  const LayerView view = disc_view(random);
  std::vector<motion::PosedPoint> points(1003);
  for (motion::PosedPoint& point : points) {
    point.position =
        view.intrinsics
            .unproject(80 * random.uniform_double() - 8, 60 * random.uniform_double() - 6, 2 + 0.03 * random.normal())
            .cast<float>();
  }
  points[5].position.z() = -2;
  std::vector<std::array<float, LayerView::kLevels>> shown(points.size());
  sample_textures(points, view, shown);
  int seen = 0;
  for (std::size_t p = 0; p < points.size(); ++p) {
    const Eigen::Vector3d position = points[p].position.cast<double>();
    const Eigen::Vector2d pixel = view.intrinsics.project(position);
    const int u = static_cast<int>(std::lround(pixel.x()));
    const int v = static_cast<int>(std::lround(pixel.y()));
    const bool inside = position.z() > 0 && pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() < view.intrinsics.width - 1 &&
                        pixel.y() < view.intrinsics.height - 1;
    const bool there =
        inside && view.mask.at(u, v) == 2 && view.planes.weights.at(u, v) > 0 &&
        std::abs(view.point(u, v).z() - position.z()) <= std::max(0.015, 3 * kSensorNoise.sigma(position.z()));
    for (std::size_t level = 0; level < shown[p].size(); ++level) {
      ASSERT_EQ(std::isnan(shown[p][level]), !there) << p;
      if (there) {
        EXPECT_NEAR(shown[p][level], view.sample_texture(static_cast<int>(level), pixel.x(), pixel.y()).value, 1e-4);
      }
    }
    seen += there ? 1 : 0;
  }
  EXPECT_GT(seen, 50);
}

TEST_P(PointAssociationTest, FindsNothingInAnEmptyView) {
  const LayerView view;
  const std::vector<motion::PosedPoint> points(5, {{0, 0, 1}, 0, {0, 0, -1}, 0});
  std::vector<DataTerm> terms(points.size());
  std::vector<float> image(points.size());
  associate_points(points, view, 0, {}, terms, image);
  for (std::size_t p = 0; p < points.size(); ++p) {
    EXPECT_EQ(terms[p].plane_scale, 0);
    EXPECT_FALSE(terms[p].violates_free_space);
    EXPECT_TRUE(std::isnan(image[p]));
  }
}

INSTANTIATE_TEST_SUITE_P(Sets, PointAssociationTest, every_instruction_set(), name_of_set);

} // namespace
} // namespace kinora::tracking
