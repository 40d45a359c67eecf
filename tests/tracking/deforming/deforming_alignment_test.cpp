#include "tracking/deforming/deforming_alignment.h"

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "core/parallel.h"
#include "core/random.h"
#include "motion/skinning/node_motions.h"
#include "tracking/scenes/bending_plate.h"

namespace kinora::tracking {
namespace {

using testing::Plate;
using testing::render_plate;

constexpr double kSpacing = 0.06;

/// A flat plate one metre away with a grid of nodes, and a view of it bent.
struct Scene {
  LayerView view;
  std::vector<Eigen::Vector3d> nodes;
  std::vector<GraphEdge> edges;
  std::vector<motion::SkinnedPoint> points;
  std::vector<PointTexture> textures;
  motion::NodeStates start;

  explicit Scene(double curvature, std::size_t most_points = 1'000'000) {
    Plate plate;
    plate.to_world = SE3(Eigen::Translation3d(0, 0, 1));
    const LayerView flat = view_label(render_plate(plate, SE3::Identity(), 0), 2);
    plate.curvature = curvature;
    view = view_label(render_plate(plate, SE3::Identity(), 1), 2);
    for (int y = -3; y <= 3; ++y) {
      for (int x = -4; x <= 4; ++x) nodes.emplace_back(kSpacing * x, kSpacing * y, 0);
    }
    for (int i = 0; i < 63; ++i) {
      if (i % 9 != 8) edges.push_back({i, i + 1});
      if (i + 9 < 63) edges.push_back({i, i + 9});
    }
    const motion::DeformationGraph graph(nodes, 1.1 * kSpacing, 2.5 * kSpacing);
    for (const Eigen::Vector3d& node : nodes) start.push_back(DualQuaternion::from(plate.to_world), node);
    for (int y = -18; y <= 18; ++y) {
      for (int x = -23; x <= 23 && points.size() < most_points; ++x) {
        const Eigen::Vector3d position(0.01 * x, 0.01 * y, 0);
        points.emplace_back(position.cast<float>(), -Eigen::Vector3f::UnitZ(), graph.influence(position));
        const Eigen::Vector2d pixel = flat.intrinsics.project(plate.to_world * position);
        PointTexture texture;
        texture.direction = 4;
        for (std::size_t level = 0; level < texture.last.size(); ++level) {
          texture.last[level] = flat.sample_texture(static_cast<int>(level), pixel.x(), pixel.y()).value;
        }
        texture.fused = texture.last[0];
        textures.push_back(texture);
      }
    }
  }
  LayerModel model() const { return {nodes, edges, points}; }
};

// Mean distance of the points from where bending by `curvature` has them.
double mean_error(const Scene& scene, const motion::NodeStates& states, double curvature) {
  Plate plate;
  plate.to_world = SE3(Eigen::Translation3d(0, 0, 1));
  plate.curvature = curvature;
  double sum = 0;
  for (const motion::SkinnedPoint& point : scene.points) {
    const Eigen::Vector3d position = point.position.cast<double>();
    sum +=
        (motion::blend_motion(states, point.influence()).apply(position) - plate.position(position.x(), position.y()))
            .norm();
  }
  return sum / static_cast<double>(scene.points.size());
}

motion::NodeStates disturbed(const Scene& scene, double size, std::uint64_t seed) {
  Random random(seed);
  std::vector<Twist> steps(scene.nodes.size());
  for (Twist& step : steps) {
    for (double& value : step) value = size * random.normal();
  }
  return motion::stepped(scene.start, steps);
}

// The derivative by the step of some nodes against differences of the energy; `tolerance` in units of its length.
void expect_gradient(DeformingProblem& problem, const motion::NodeStates& states, double size, double tolerance) {
  const std::span<const motion::SkinnedPoint> points = problem.model().points;
  double energy_there = 0;
  const motion::LayerPose pose = motion::pose_layer(points, states);
  const BlockSystem system = problem.linearise(pose, energy_there);
  EXPECT_NEAR(energy_there, problem.energy(pose), 1e-6 * energy_there);
  for (const std::size_t node : {0U, 20U, 31U, 40U, 62U}) {
    for (int i = 0; i < 6; ++i) {
      const auto energy = [&](double step) {
        std::vector<Twist> steps(states.size(), Twist::Zero());
        steps[node][i] = step;
        return problem.energy(motion::pose_layer(points, motion::stepped(states, steps)));
      };
      const double expected = (energy(size) - energy(-size)) / (2 * size);
      EXPECT_NEAR(system.gradient[node][i], expected, tolerance * (1 + system.gradient[node].norm()))
          << node << ' ' << i;
    }
  }
}

TEST(DeformingProblem, GradientOfDepthAndRigidityAgreesWithDifferences) {
  const Scene scene(0.8);
  const LayerModel model = scene.model();
  DeformingProblem problem(model, scene.view, {});
  DeformingAlignmentConfig config;
  config.photometric_weight = 0;
  associate(model, scene.textures, scene.view, motion::pose_layer(scene.points, scene.start), 0, 0.1, config,
            problem.terms());
  problem.set_prior(scene.start);
  // Steps are large against the rounding of floats.
  expect_gradient(problem, disturbed(scene, 0.02, 4), 1e-4, 5e-3);
}

TEST(DeformingProblem, GradientOfTheBindingAgreesWithDifferences) {
  const Scene scene(0.8);
  const LayerModel model = scene.model();
  DeformingProblem problem(model, scene.view, {});
  std::vector<NodeTarget> binding;
  for (std::size_t n = 0; n < scene.nodes.size(); ++n) {
    const double away = n % 2 == 0 ? 0.01 : 0.2; // some within the bend of the loss, some beyond
    binding.push_back({scene.start.positions[n] + Eigen::Vector3d(away, 0, away), n % 3 == 0 ? 0 : 50.0});
  }
  problem.set_binding(binding);
  problem.set_rigidity_sigma(1);
  expect_gradient(problem, disturbed(scene, 0.02, 6), 1e-4, 2e-3);
}

TEST(DeformingProblem, GradientOfTextureAgreesWithDifferences) {
  Scene scene(0.8);
  // A ramp of brightness: its interpolation and its slope are exact.
  Image<float>& image = scene.view.pyramid[0].values;
  for (int v = 0; v < image.height(); ++v) {
    for (int u = 0; u < image.width(); ++u) {
      float* pixel = image.pixel(u, v);
      pixel[0] = 0.02F * static_cast<float>(u) - 0.03F * static_cast<float>(v);
      pixel[1] = 0.02F;
      pixel[2] = -0.03F;
    }
  }
  const LayerModel model = scene.model();
  DeformingProblem problem(model, scene.view, {});
  associate(model, scene.textures, scene.view, motion::pose_layer(scene.points, scene.start), 0, 0.1, {},
            problem.terms());
  for (DataTerm& terms : problem.terms()) terms.plane_scale = 0;
  problem.set_rigidity_sigma(1);
  expect_gradient(problem, disturbed(scene, 0.005, 5), 1e-3, 0.01);
}

TEST(DeformingProblem, RigidGradientAgreesWithDifferencesOfTheEnergy) {
  const Scene scene(0.8);
  const LayerModel model = scene.model();
  DeformingProblem problem(model, scene.view, {});
  DeformingAlignmentConfig config;
  config.photometric_weight = 0;
  associate(model, scene.textures, scene.view, motion::pose_layer(scene.points, scene.start), 0, 0.1, config,
            problem.terms());
  Matrix6d information;
  Twist gradient;
  const Eigen::Vector3d pivot(0, 0, 1);
  problem.linearise_rigid(motion::pose_layer(scene.points, scene.start), pivot, information, gradient);
  for (int i = 0; i < 6; ++i) {
    constexpr double kStep = 1e-4;
    const auto energy = [&](double step) {
      Twist twist = Twist::Zero();
      twist[i] = step;
      const SE3 motion(Eigen::Translation3d(pivot) * exp_se3(twist) * Eigen::Translation3d(-pivot));
      return problem.energy(motion::pose_layer(scene.points, moved(scene.start, motion)));
    };
    EXPECT_NEAR(gradient[i], (energy(kStep) - energy(-kStep)) / (2 * kStep), 1e-3 * (1 + gradient.norm())) << i;
  }
}

TEST(DeformingAlignment, BendsAPlateIntoPlace) {
  const Scene scene(1.2);
  const double before = mean_error(scene, scene.start, 1.2);
  const auto result = align_deforming(scene.model(), scene.textures, scene.view, scene.start, scene.start, kSpacing);
  EXPECT_GT(before, 0.01);
  EXPECT_LT(mean_error(scene, result.nodes, 1.2), 0.003);
}

// Along itself a flat plate looks alike for depth; without texture only its outline says where it is.
TEST(DeformingAlignment, SilhouetteHoldsAPlateWithoutTexture) {
  const Scene scene(0);
  SE3 aside = SE3::Identity();
  aside.translation() = Eigen::Vector3d(0.06, 0.05, 0); // the points end 2 cm within the outline
  const motion::NodeStates start = moved(scene.start, aside);
  DeformingAlignmentConfig config;
  config.photometric_weight = 0;
  config.prior_sigma = 1;
  config.silhouette_weight = 0;
  const auto slipped = align_deforming(scene.model(), scene.textures, scene.view, start, start, kSpacing, config);
  EXPECT_GT(mean_error(scene, slipped.nodes, 0), 0.06);
  config.silhouette_weight = DeformingAlignmentConfig().silhouette_weight;
  const auto contact = align_deforming(scene.model(), scene.textures, scene.view, start, start, kSpacing, config);
  EXPECT_LT(mean_error(scene, contact.nodes, 0), 0.035);
}

// The right half of the plate is not seen: bones may bend it. What is seen does not give way to them.
TEST(DeformingAlignment, BonesMoveWhatIsNotSeen) {
  Scene scene(0);
  for (std::size_t p = scene.points.size(); p-- > 0;) {
    if (scene.points[p].position.x() <= 0) continue;
    scene.points.erase(scene.points.begin() + static_cast<std::ptrdiff_t>(p));
    scene.textures.erase(scene.textures.begin() + static_cast<std::ptrdiff_t>(p));
  }
  const Eigen::Vector3d away(0, 0, 0.08);
  std::vector<NodeTarget> binding;
  for (const Eigen::Vector3d& position : scene.start.positions) binding.push_back({position + away, 50});
  const auto alone = align_deforming(scene.model(), scene.textures, scene.view, scene.start, scene.start, kSpacing);
  const auto bound =
      align_deforming(scene.model(), scene.textures, scene.view, scene.start, scene.start, kSpacing, {}, binding);
  const std::size_t left = 28;
  const std::size_t right = 35;
  EXPECT_LT((alone.nodes.positions[right] - scene.start.positions[right]).norm(), 0.02);
  EXPECT_LT((bound.nodes.positions[right] - binding[right].position).norm(), 0.02);
  EXPECT_LT((bound.nodes.positions[left] - scene.start.positions[left]).norm(), 0.005);
  EXPECT_GT(bound.seen[left], 0.8);
  EXPECT_EQ(bound.seen[right], 0);
}

// Nothing of the plate's right half is on its label: something stands before it, or the camera sees what lies behind.
TEST(DeformingAlignment, BonesDoNotMoveWhatTheCameraSeesPast) {
  const Eigen::Vector3d away(0, 0, 0.08);
  constexpr std::size_t kRight = 35;
  const auto bound_at = [&](float measured) {
    Scene scene(0);
    LayerView& view = scene.view;
    for (int v = 0; v < view.mask.height(); ++v) {
      for (int u = view.mask.width() / 2; u < view.mask.width(); ++u) {
        view.mask.at(u, v) = 0;
        view.planes.weights.at(u, v) = 0;
        view.depth.at(u, v) = measured;
      }
    }
    view.to_silhouette = offsets_to_silhouette(view.mask);
    std::vector<NodeTarget> binding;
    for (const Eigen::Vector3d& position : scene.start.positions) binding.push_back({position + away, 50});
    const auto bound =
        align_deforming(scene.model(), scene.textures, view, scene.start, scene.start, kSpacing, {}, binding);
    return (bound.nodes.positions[kRight] - binding[kRight].position).norm();
  };
  EXPECT_LT(bound_at(0.3F), 0.02);
  EXPECT_GT(bound_at(9.0F), 0.05);
}

TEST(DeformingAlignment, EnergyNeverRises) {
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U, 5U, 6U}) {
    const Scene scene(0.3 * static_cast<double>(seed));
    const motion::NodeStates start = disturbed(scene, 0.02, seed);
    const auto result = align_deforming(scene.model(), scene.textures, scene.view, start, start, kSpacing);
    ASSERT_GE(result.energies.size(), 6U);
    for (std::size_t i = 0; i + 1 < result.energies.size(); i += 2) {
      EXPECT_LT(result.energies[i + 1], result.energies[i]) << seed;
    }
  }
}

// The canonical space may lie any way.
TEST(DeformingAlignment, IsTheSameAfterATurnOf179Point9Degrees) {
  Scene scene(1.0);
  scene.start = disturbed(scene, 0.02, 3);
  const SE3 rotation(Eigen::AngleAxisd(179.9 / 180 * std::numbers::pi, Eigen::Vector3d(1, 2, 3).normalized()));
  Scene rotated = scene;
  rotated.start = {};
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    rotated.nodes[i] = rotation * scene.nodes[i];
    rotated.start.push_back(SE3(scene.start.transforms[i].to_se3() * rotation.inverse()), rotated.nodes[i]);
  }
  for (motion::SkinnedPoint& point : rotated.points) {
    const motion::Influence influence = point.influence();
    point = motion::SkinnedPoint((rotation * point.position.cast<double>()).cast<float>(),
                                 (rotation.linear() * point.normal.cast<double>()).cast<float>(), influence);
  }
  const auto a = align_deforming(scene.model(), scene.textures, scene.view, scene.start, scene.start, kSpacing);
  const auto b =
      align_deforming(rotated.model(), rotated.textures, rotated.view, rotated.start, rotated.start, kSpacing);
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    EXPECT_LT((a.nodes.positions[i] - b.nodes.positions[i]).norm(), 1e-4) << i;
  }
}

TEST(DeformingAlignment, IsTheSameForOneThreadAndMany) {
  const Scene scene(1.2);
  std::vector<motion::NodeStates> results;
  for (const int threads : {1, 4}) {
    set_thread_count(threads);
    results.push_back(
        align_deforming(scene.model(), scene.textures, scene.view, scene.start, scene.start, kSpacing).nodes);
  }
  set_thread_count(0);
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    EXPECT_EQ(results[0].positions[i], results[1].positions[i]);
    EXPECT_EQ(results[0].transforms[i].real.coeffs(), results[1].transforms[i].real.coeffs());
  }
}

TEST(DeformingAlignment, KeepsNodesInPlaceForHardlyAnyPoints) {
  for (const std::size_t count : {0U, 1U, 5U}) {
    const Scene scene(0.3, count);
    const auto result = align_deforming(scene.model(), scene.textures, scene.view, scene.start, scene.start, kSpacing);
    for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
      ASSERT_TRUE(result.nodes.positions[i].allFinite()) << count;
      EXPECT_LT((result.nodes.positions[i] - scene.start.positions[i]).norm(), 0.05) << count << ' ' << i;
    }
  }
}

TEST(DeformingAlignment, DoesNotCareForTheSignOfQuaternions) {
  const Scene scene(1.0);
  motion::NodeStates flipped = scene.start;
  for (std::size_t i = 0; i < flipped.size(); i += 2)
    flipped.transforms[i] = motion::testing::negated(flipped.transforms[i]);
  const auto a = align_deforming(scene.model(), scene.textures, scene.view, scene.start, scene.start, kSpacing);
  const auto b = align_deforming(scene.model(), scene.textures, scene.view, flipped, flipped, kSpacing);
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    EXPECT_LT((a.nodes.positions[i] - b.nodes.positions[i]).norm(), 1e-9);
  }
}

} // namespace
} // namespace kinora::tracking
