#include "tracking/body/body_model.h"

#include <gtest/gtest.h>

#include "core/random.h"

namespace kinora::tracking {
namespace {

Eigen::Vector3d random_vector(Random& random) { return {random.normal(), random.normal(), random.normal()}; }

Shape random_shape(std::uint64_t seed) {
  Random random(seed);
  Shape shape;
  for (double& measure : shape) measure = 0.15 * random.normal();
  return shape;
}

// The nearest of many points of the surface.
double searched_distance(const PartShape& part, const Eigen::Vector3d& position) {
  double least = 1e9;
  for (int i = 0; i <= 200; ++i) {
    const double along = i / 200.0;
    const Eigen::Vector3d centre = part.a + along * (part.b - part.a);
    const double radius = part.radius_a + along * (part.radius_b - part.radius_a);
    least = std::min(least, (position - centre).norm() - radius);
  }
  return least;
}

TEST(BodyModel, TheDistanceOfARoundPartIsTheLeastOverItsSpheres) {
  Random random(1);
  for (const BodyPart& part : body_parts()) {
    if (part.width != 1) continue;
    const PartShape shape = shape_of(part, Shape::Zero());
    for (int i = 0; i < 50; ++i) {
      const Eigen::Vector3d position = shape.centre + 0.2 * random_vector(random);
      EXPECT_NEAR(closest_surface(shape, position).distance, searched_distance(shape, position), 1e-4);
    }
  }
}

TEST(BodyModel, NearEveryPartTheClosestSurfaceIsWhereTheNormalLeads) {
  Random random(2);
  for (const BodyPart& part : body_parts()) {
    const PartShape shape = shape_of(part, random_shape(3));
    for (int i = 0; i < 50; ++i) {
      const PartPoint start{random.uniform_double(), random_vector(random).normalized()};
      const Eigen::Vector3d on_surface = position_of(shape, closest_surface(shape, position_of(shape, start)).point);
      const Eigen::Vector3d outside = on_surface + 0.002 * closest_surface(shape, on_surface).normal;
      const ClosestSurface found = closest_surface(shape, outside);
      EXPECT_NEAR(found.distance, 0.002, 2e-4);
      EXPECT_LT((outside - found.distance * found.normal - position_of(shape, found.point)).norm(), 1e-3);
    }
  }
}

TEST(BodyModel, MeasuresMoveTheSurfaceAsTheirDerivativesSay) {
  constexpr double kStep = 1e-6;
  Random random(4);
  const Shape shape = random_shape(5);
  for (const BodyPart& part : body_parts()) {
    const PartPoint point{random.uniform_double(), random_vector(random).normalized()};
    const Eigen::Vector3d direction = random_vector(random).normalized();
    const auto derivative = measure_derivative(shape_of(part, shape), point, direction);
    Shape analytic = Shape::Zero();
    const auto measures = measures_of(part);
    for (int m = 0; m < kPartMeasures; ++m) {
      const auto measure = measures[static_cast<std::size_t>(m)];
      if (measure) analytic[*measure] += derivative[m];
    }
    for (int m = 0; m < kMeasures; ++m) {
      const Shape step = kStep * Shape::Unit(m);
      const Eigen::Vector3d change =
          position_of(shape_of(part, shape + step), point) - position_of(shape_of(part, shape - step), point);
      EXPECT_NEAR(change.dot(direction) / (2 * kStep), analytic[m], 1e-8) << joints()[part.bone].name << ", " << m;
    }
  }
}

TEST(BodyModel, SamplesLieOnTheSurfaceAndNotInOtherParts) {
  const PosedBody body = pose_body(BodyPose(), Shape::Zero());
  ASSERT_GT(body_samples().size(), 500U);
  double area = 0;
  for (const BodySample& sample : body_samples()) {
    const Eigen::Vector3d position = position_of(body.parts[sample.part], sample.point);
    area += sample.area;
    EXPECT_LT(std::abs(closest_surface(body.parts[sample.part], position).distance), 0.004);
    const Eigen::Vector3d outside = body.bones[body_parts()[sample.part].bone] * position;
    for (std::size_t i = 0; i < kBodyParts; ++i) {
      if (i == sample.part) continue;
      const SE3& bone = body.bones[body_parts()[i].bone];
      EXPECT_GT(closest_surface(body.parts[i], bone.inverse() * outside).distance, -0.006);
    }
  }
  EXPECT_NEAR(area, 1.8, 0.4); // metres²: what people have (DuBois and DuBois, 1916)
}

} // namespace
} // namespace kinora::tracking
