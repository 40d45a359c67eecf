#include "tracking/solver/data_term.h"

#include <cmath>

#include "core/robust_cost.h"
#include "motion/skinning/node_motions.h"
#include "support/every_instruction_set.h"

namespace kinora::tracking {
namespace {

using motion::testing::random_vector;

constexpr Huber kHuber{kHuberThreshold};
constexpr int kNodes = 20;

/// Points about two metres away, some without terms, some beside the picture, on a smooth texture.
struct Scene {
  LayerView view;
  motion::NodeStates states;
  std::vector<motion::SkinnedPoint> points;
  std::vector<DataTerm> terms;
  motion::LayerPose pose;

  Scene() {
    Random random(4);
    view.intrinsics = {64, 48, 60, 50, 30, 20};
    Image<float> values(view.intrinsics.width, view.intrinsics.height);
    for (int v = 0; v < values.height(); ++v) {
      for (int u = 0; u < values.width(); ++u) values.at(u, v) = std::sin(0.2F * static_cast<float>(u + 2 * v));
    }
    view.pyramid = texture_pyramid(values, 1);
    for (int n = 0; n < kNodes; ++n) {
      Twist twist;
      twist << random_vector(random, 0.1) + Eigen::Vector3d(0, 0, 2), random_vector(random, 0.2);
      states.push_back(DualQuaternion::from(exp_se3(twist)), random_vector(random, 0.3));
    }
    for (std::size_t p = 0; p < 77; ++p) {
      motion::Influence influence;
      influence.count = 1 + static_cast<int>(p % motion::Influence::kMax);
      for (std::size_t k = 0; k < static_cast<std::size_t>(influence.count); ++k) {
        influence.nodes[k] = static_cast<int>((p + 3 * k) % kNodes);
        influence.weights[k] = 1.0 / influence.count;
      }
      points.emplace_back(random_vector(random, 0.5).cast<float>(), Eigen::Vector3f::UnitZ(), influence);
    }
    pose = motion::pose_layer(points, states);
    for (std::size_t p = 0; p < points.size(); ++p) {
      DataTerm term;
      if (p % 3 != 0) {
        term.plane_normal = random_vector(random, 1).normalized().cast<float>();
        term.plane_offset =
            0.01F * static_cast<float>(random.normal()) - term.plane_normal.dot(pose.points[p].position);
        term.plane_scale = 300;
      }
      if (p % 4 > 1) term.texture_scale = {20, 0};
      if (p % 4 > 2) term.texture_scale[1] = 10;
      term.expected = {static_cast<float>(random.normal()), static_cast<float>(random.normal())};
      terms.push_back(term);
    }
  }
};

struct Plain {
  double energy = 0;
  double residuals[2] = {};
  Eigen::Vector3d gradients[2] = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
};

Plain plain_rows(const Scene& s, std::size_t p, int level) {
  Plain result;
  const DataTerm& terms = s.terms[p];
  const Eigen::Vector3d position = s.pose.points[p].position.cast<double>();
  const Eigen::Vector3d normal = terms.plane_normal.cast<double>();
  const double plane = terms.plane_scale * (normal.dot(position) + terms.plane_offset);
  result.energy = kHuber.cost(plane);
  result.residuals[0] = std::sqrt(kHuber.weight(plane)) * plane;
  result.gradients[0] = std::sqrt(kHuber.weight(plane)) * terms.plane_scale * normal;
  const double fx = s.view.intrinsics.fx / position.z();
  const double fy = s.view.intrinsics.fy / position.z();
  const TextureSample image =
      s.view.sample_texture(level, fx * position.x() + s.view.intrinsics.cx, fy * position.y() + s.view.intrinsics.cy);
  const Eigen::Vector3d texture_gradient(image.du * fx, image.dv * fy,
                                         -(image.du * fx * position.x() + image.dv * fy * position.y()) / position.z());
  double information = 0;
  double sum = 0;
  for (std::size_t t = 0; t < DataTerm::kTextures; ++t) {
    const double scale = terms.texture_scale[t];
    const double value = scale * (image.value - terms.expected[t]);
    result.energy += kHuber.cost(value);
    information += kHuber.weight(value) * scale * scale;
    sum += kHuber.weight(value) * scale * value;
  }
  if (information > 0 && !texture_gradient.isZero(0)) {
    result.residuals[1] = sum / std::sqrt(information);
    result.gradients[1] = std::sqrt(information) * texture_gradient;
  }
  return result;
}

class DataTermTest : public OnEveryInstructionSet {};

TEST_P(DataTermTest, AreThoseOfAPlainLoop) {
  const Scene s;
  for (const int level : {0, 1, 2}) {
    const TextureImage texture = texture_image(s.view, level);
    std::vector<ResidualRows> rows(s.points.size());
    std::vector<PointJacobians> jacobians(s.points.size());
    const double energy = data_energy(s.pose.points, s.terms, texture, kHuber.threshold);
    EXPECT_NEAR(evaluate_rows(s.pose.points, s.terms, texture, kHuber.threshold, rows), energy, 1e-5 * energy);
    EXPECT_NEAR(evaluate_jacobians(s.points, s.pose.rows, s.pose.points, s.terms, texture, kHuber.threshold, jacobians),
                energy, 1e-5 * energy);
    double expected = 0;
    for (std::size_t p = 0; p < s.points.size(); ++p) {
      const Plain plain = plain_rows(s, p, level);
      expected += plain.energy;
      const Eigen::Vector3d position = s.pose.points[p].position.cast<double>();
      const motion::Influence influence = s.points[p].influence();
      const motion::BlendedMotion blended = motion::blend_motion(s.states, influence);
      const bool empty = plain.gradients[0].isZero(0) && plain.gradients[1].isZero(0);
      EXPECT_EQ(jacobians[p].empty, empty) << p;
      for (std::size_t r = 0; r < PointJacobians::kRows; ++r) {
        const Eigen::Vector3d& gradient = plain.gradients[r];
        const double tolerance = 2e-4 * (1 + gradient.norm());
        EXPECT_LT((rows[p][r].gradient.cast<double>() - gradient).norm(), tolerance) << p << ' ' << r;
        EXPECT_NEAR(rows[p][r].residual, plain.residuals[r], tolerance) << p << ' ' << r;
        EXPECT_EQ(jacobians[p].residuals[r], rows[p][r].residual) << p << ' ' << r;
        if (empty) continue;
        for (std::size_t k = 0; k < static_cast<std::size_t>(influence.count); ++k) {
          const Twist derivative =
              motion::NodeJacobian(s.states, influence, blended, k).pullback(gradient, position.cross(gradient));
          for (Eigen::Index i = 0; i < 6; ++i) {
            EXPECT_NEAR(jacobians[p].by_node[k][r][static_cast<std::size_t>(i)], derivative[i], tolerance)
                << p << ' ' << r << ' ' << k << ' ' << i;
          }
        }
      }
    }
    EXPECT_NEAR(energy, expected, 1e-4 * expected);
  }
}

INSTANTIATE_TEST_SUITE_P(Sets, DataTermTest, every_instruction_set(), name_of_set);

} // namespace
} // namespace kinora::tracking
