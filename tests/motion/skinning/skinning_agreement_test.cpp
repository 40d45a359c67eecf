// Tracker, trainer, renderer and exports move points by nodes alike: the same points through each of them, on every
// instruction set.
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>

#include <gtest/gtest.h>

#include "bake/skinning.h"
#include "fields/rendering/proxy_mesh_kernels.h"
#include "motion/bulk_warp.h"
#include "motion/skinning/layer_pose.h"
#include "motion/skinning/skinned_lanes.h"
#include "node_motions.h"
#include "support/every_instruction_set.h"
#include "tracking/solver/data_term.h"

namespace kinora::motion {
namespace {

using Eigen::Vector3d;
using testing::random_vector;

/// By how much the ways may differ where nodes lie within a third of a metre and turn by any angle; several times what
/// they do. Points: metres, of what single precision leaves; it says the same of weights to a hundred-thousandth.
constexpr double kPointBound = 2e-6;
constexpr double kVectorBound = 2e-5;
constexpr double kDerivativeBound = 5e-5;

/// Nodes in a cube, each with a transform of its own, and the same relative to origins near them.
struct Scene {
  std::shared_ptr<const DeformationGraph> graph;
  std::vector<DualQuaternion> node_to_world;
  Warp warp;
  BulkWarp bulk;
  NodeStates states; // relative to the origins of `bulk`
  NodeRows rows;
  std::vector<PositionRow> nodes;

  Scene(std::vector<Vector3d> positions, std::vector<DualQuaternion> transforms)
      : graph(std::make_shared<const DeformationGraph>(std::move(positions), 0.05, 0.12)),
        node_to_world(std::move(transforms)), warp(graph, node_to_world),
        bulk(std::make_shared<const InfluenceTable>(graph), warp) {
    for (std::size_t n = 0; n < node_to_world.size(); ++n) {
      SE3 relative = node_to_world[n].to_se3();
      relative.translation() += relative.linear() * canonical_origin() - world_origin();
      states.push_back(relative, graph->nodes()[n] - canonical_origin());
    }
    rows = rows_of(states);
    nodes = position_rows(graph->nodes(), canonical_origin());
  }
  const Vector3d& canonical_origin() const { return bulk.canonical_origin(); }
  const Vector3d& world_origin() const { return bulk.world_origin(); }
};

using MotionOf = std::function<SE3(Random&, std::size_t node)>;

Scene scene_of(std::uint64_t seed, std::size_t count, const MotionOf& motion_of,
               const Vector3d& far = Vector3d::Zero()) {
  Random random(seed);
  std::vector<Vector3d> nodes;
  std::vector<DualQuaternion> transforms;
  for (std::size_t n = 0; n < count; ++n) {
    nodes.push_back(far + 0.3 * Vector3d(random.uniform_double(), random.uniform_double(), random.uniform_double()));
    const SE3 about_node = Eigen::Translation3d(nodes[n]) * motion_of(random, n) * Eigen::Translation3d(-nodes[n]);
    transforms.push_back(DualQuaternion::from(SE3(Eigen::Translation3d(-3 * far) * about_node)));
    if (n % 3 == 0) transforms.back() = testing::negated(transforms.back());
  }
  return {std::move(nodes), std::move(transforms)};
}

SE3 small_motion(Random& random, std::size_t) {
  Twist twist;
  twist << random_vector(random, 0.03), random_vector(random, 0.3);
  return exp_se3(twist);
}
SE3 any_rotation(Random& random, std::size_t) {
  return SE3(Eigen::Quaterniond(random.normal(), random.normal(), random.normal(), random.normal()).normalized());
}
SE3 opposed_rotation(Random&, std::size_t node) {
  const double angle = node % 2 == 0 ? 0 : 179.9 / 180 * std::numbers::pi;
  return SE3(Eigen::AngleAxisd(angle, Vector3d(1, 2, 3).normalized()));
}

std::vector<Scene> scenes() {
  std::vector<Scene> scenes;
  scenes.push_back(scene_of(1, 200, small_motion));
  scenes.push_back(scene_of(2, 200, any_rotation));
  scenes.push_back(scene_of(3, 200, opposed_rotation));
  scenes.push_back(scene_of(4, 1, any_rotation));
  scenes.push_back(scene_of(5, 4, small_motion));
  scenes.push_back(scene_of(6, 100, small_motion, {30, -20, 10}));
  scenes.push_back(scene_of(7, 100, opposed_rotation, {-300, 200, 1000}));
  return scenes;
}

/// Where a point is in the world, and where a vector at it points; nothing where no node moves it.
struct Posed {
  Vector3d point, vector;
};
using Poses = std::vector<std::optional<Posed>>;

const Vector3d kVector = Vector3d(3, -2, 1).normalized();

Posed reference(const Scene& s, const Influence& influence, const Vector3d& canonical) {
  const BlendedMotion motion = blend_motion(s.states, influence);
  return {motion.apply(canonical - s.canonical_origin()) + s.world_origin(), motion.rotate(kVector)};
}

/// Points among the nodes and beyond them all, but for those where the blend jumps, by its definition: on the edge of
/// the nodes' reach, and where rounding decides which node is the heaviest or which of two ways round is the shorter.
std::vector<Vector3d> points_of(const Scene& s) {
  Random random(11);
  std::vector<Vector3d> points;
  while (points.size() < 400) {
    Vector3d p = s.graph->nodes()[random.below(s.graph->nodes().size())] + random_vector(random, 0.05);
    if (points.size() % 10 == 0) p += random_vector(random, 0.3);
    if (points.size() % 50 == 0) p = s.graph->nodes()[random.below(s.graph->nodes().size())];
    double nearest = std::numeric_limits<double>::infinity();
    for (const Vector3d& node : s.graph->nodes()) nearest = std::min(nearest, (node - p).norm());
    if (std::abs(nearest - s.graph->influence_radius()) < 1e-4) continue;
    const Influence influence = s.graph->influence(p);
    bool jumps = influence.count > 1 && influence.weights[0] - influence.weights[1] < 1e-3;
    for (std::size_t k = 0; k < static_cast<std::size_t>(influence.count); ++k) {
      const auto& heaviest = s.states.transforms[static_cast<std::size_t>(influence.nodes[0])].real;
      const auto& other = s.states.transforms[static_cast<std::size_t>(influence.nodes[k])].real;
      if (std::abs(heaviest.dot(other)) < 1e-5) jumps = true;
    }
    if (!jumps) points.push_back(p);
  }
  return points;
}

Poses by_warp(const Scene& s, std::span<const Vector3d> points) {
  Poses poses;
  for (const Vector3d& p : points) {
    const auto transform = s.warp.at(p);
    poses.push_back(transform ? std::optional<Posed>({*transform * p, transform->linear() * kVector}) : std::nullopt);
  }
  return poses;
}

Eigen::Vector3f relative(const Scene& s, const Vector3d& point) { return (point - s.canonical_origin()).cast<float>(); }

Poses to_world(const Scene& s, std::span<const Eigen::Vector3f> points, std::span<const Eigen::Vector3f> vectors) {
  Poses poses;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i].hasNaN()) {
      poses.emplace_back();
    } else {
      poses.push_back({{points[i].cast<double>() + s.world_origin(), vectors[i].cast<double>()}});
    }
  }
  return poses;
}

Poses by_bulk_warp(const Scene& s, std::span<const Vector3d> points) {
  std::vector<std::array<float, 3>> in;
  for (const Vector3d& p : points) {
    const Eigen::Vector3f at = relative(s, p);
    in.push_back({at.x(), at.y(), at.z()});
  }
  std::vector<BulkWarp::WarpedPoint> out(in.size());
  s.bulk.to_world(in, out.data());
  std::vector<Eigen::Vector3f> skinned_positions, rotated_vectors;
  for (const BulkWarp::WarpedPoint& warped : out) {
    skinned_positions.emplace_back(warped.point.data());
    rotated_vectors.emplace_back(Eigen::Quaternionf(warped.rotation.data()) * kVector.cast<float>());
  }
  return to_world(s, skinned_positions, rotated_vectors);
}

Poses by_layer_pose(const Scene& s, std::span<const Vector3d> points) {
  std::vector<SkinnedPoint> skinned;
  for (const Vector3d& p : points) skinned.emplace_back(relative(s, p), kVector.cast<float>(), s.graph->influence(p));
  std::vector<Eigen::Vector3f> skinned_positions, rotated_vectors;
  for (const PosedPoint& point : pose_layer(skinned, s.states).points) {
    skinned_positions.push_back(point.position);
    rotated_vectors.push_back(point.normal);
  }
  return to_world(s, skinned_positions, rotated_vectors);
}

Poses by_lanes(const Scene& s, std::span<const Vector3d> points) {
  std::vector<std::int32_t> all(s.nodes.size()); // NodeCandidates::kMax at most
  for (std::size_t n = 0; n < all.size(); ++n) all[n] = static_cast<std::int32_t>(n);
  const auto influence_radius = static_cast<float>(s.graph->influence_radius());
  const auto weight_radius = static_cast<float>(s.graph->weight_radius());
  std::vector<Eigen::Vector3f> skinned_positions, rotated_vectors;
  for (std::size_t first = 0; first < points.size(); first += PointLanes::kPoints) {
    PointLanes in{}, vectors{}, out, rotated;
    for (std::size_t i = 0; i < PointLanes::kPoints; ++i) {
      in.set(i, relative(s, points[first + i]));
      vectors.set(i, kVector.cast<float>());
    }
    InfluenceLanes influences;
    skinning_weights({all, s.nodes.data(), influence_radius, weight_radius}, in, influences);
    skin_points(s.rows.transforms, influences, in, out, vectors, rotated);
    for (std::size_t i = 0; i < PointLanes::kPoints; ++i) {
      skinned_positions.push_back(out.at(i));
      rotated_vectors.push_back(rotated.at(i));
    }
  }
  return to_world(s, skinned_positions, rotated_vectors);
}

Poses by_hull(const Scene& s, std::span<const Vector3d> points) {
  fields::kernels::Influences influences(points.size());
  const std::size_t padded = points.size() + fields::kernels::kPadding;
  std::vector<Eigen::Vector3f> in(padded, Eigen::Vector3f::Zero());
  for (std::size_t i = 0; i < points.size(); ++i) {
    influences.set(i, s.graph->influence(points[i]));
    in[i] = relative(s, points[i]);
  }
  fields::kernels::SkinnedPoints out{in, std::vector<Eigen::Vector4f>(padded)};
  fields::kernels::skin(influences, s.rows.transforms.data(), in.data(), 1, 0, points.size(), out);
  out.world.resize(points.size());
  std::vector<Eigen::Vector3f> rotated_vectors;
  for (std::size_t i = 0; i < points.size(); ++i) {
    rotated_vectors.emplace_back(Eigen::Quaternionf(out.rotation[i]) * kVector.cast<float>());
  }
  return to_world(s, out.world, rotated_vectors);
}

class SkinningAgreement : public OnEveryInstructionSet {};

TEST_P(SkinningAgreement, EveryWayHasPointsAndVectorsWhereBlendingHasThem) {
  const std::pair<const char*, Poses (*)(const Scene&, std::span<const Vector3d>)> ways[] = {
      {"Warp", by_warp},   {"BulkWarp", by_bulk_warp}, {"pose_layer", by_layer_pose},
      {"lanes", by_lanes}, {"hull", by_hull},
  };
  int number = 0;
  for (const Scene& s : scenes()) {
    ++number;
    const std::vector<Vector3d> points = points_of(s);
    for (const auto& [name, way] : ways) {
      const Poses found = way(s, points);
      ASSERT_EQ(found.size(), points.size());
      int moved = 0;
      for (std::size_t i = 0; i < points.size(); ++i) {
        const Influence influence = s.graph->influence(points[i]);
        ASSERT_EQ(found[i].has_value(), influence.count > 0) << name << ", scene " << number << ", point " << i;
        if (influence.count == 0) continue;
        ++moved;
        const Posed wanted = reference(s, influence, points[i]);
        EXPECT_LT((found[i]->point - wanted.point).norm(), kPointBound)
            << name << ", scene " << number << ", point " << i;
        EXPECT_LT((found[i]->vector - wanted.vector).norm(), kVectorBound) << name << ", scene " << number;
      }
      EXPECT_GT(moved, 250);
      EXPECT_LT(moved, 400);
    }
  }
}

// Blended as dual quaternions: players of meshes blend matrices, which is another thing
// (Skinning::blending_difference).
TEST_P(SkinningAgreement, ExportedJointsAndWeightsAreThoseOfTheWarp) {
  for (const Scene& s : scenes()) {
    host::Mesh mesh;
    for (const Vector3d& p : points_of(s)) {
      if (s.graph->influence(p.cast<float>().cast<double>()).count > 0) mesh.positions.push_back(p.cast<float>());
    }
    const bake::Skinning skinning(Motion::deforming(s.graph, {{s.node_to_world, Health::kTracked}}), mesh);
    const std::vector<SE3> joints = skinning.joints_at(0);
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
      std::vector<DualQuaternion> transforms;
      std::vector<double> weights;
      for (std::size_t k = 0; k < 4; ++k) {
        const std::size_t joint = mesh.skin.joints[v][k];
        transforms.push_back(DualQuaternion::from(joints[joint] * mesh.skin.inverse_bind[joint]));
        weights.push_back(static_cast<double>(mesh.skin.weights[v][k]));
      }
      const Vector3d p = mesh.positions[v].cast<double>();
      EXPECT_LT((blend(transforms, weights).to_se3() * p - *s.warp.to_world(p)).norm(), kPointBound);
    }
  }
}

TEST_P(SkinningAgreement, TheSolversDerivativesAreThoseOfTheBlend) {
  const tracking::TextureImage no_texture{1, 1, 0, 0, nullptr, 0, 0, 0};
  for (const Scene& s : scenes()) {
    std::vector<SkinnedPoint> skinned;
    for (const Vector3d& p : points_of(s)) {
      const Influence influence = s.graph->influence(p);
      if (influence.count > 0) skinned.emplace_back(relative(s, p), Eigen::Vector3f::UnitZ(), influence);
    }
    const LayerPose pose = pose_layer(skinned, s.states);
    tracking::DataTerm term; // how far a point is along a vector
    term.plane_normal = kVector.cast<float>();
    term.plane_scale = 1;
    std::vector<tracking::DataTerm> terms(skinned.size(), term);
    for (std::size_t i = 0; i < skinned.size(); ++i)
      terms[i].plane_offset = -term.plane_normal.dot(pose.points[i].position);
    std::vector<tracking::PointJacobians> jacobians(skinned.size());
    evaluate_jacobians(skinned, pose.rows, pose.points, terms, no_texture, 1, jacobians);
    for (std::size_t i = 0; i < skinned.size(); ++i) {
      const Influence influence = skinned[i].influence();
      const BlendedMotion blended = blend_motion(s.states, influence);
      const Vector3d position = blended.apply(skinned[i].position.cast<double>());
      for (std::size_t k = 0; k < static_cast<std::size_t>(influence.count); ++k) {
        const Twist wanted = NodeJacobian(s.states, influence, blended, k).pullback(kVector, position.cross(kVector));
        for (Eigen::Index a = 0; a < 6; ++a) {
          EXPECT_NEAR(jacobians[i].by_node[k][0][static_cast<std::size_t>(a)], wanted[a], kDerivativeBound)
              << i << ' ' << k;
        }
      }
    }
  }
}

// The plain sum of these half turns vanishes; in the hemisphere of one of them none can (core/dual_quaternion.h).
TEST_P(SkinningAgreement, WhereRotationsCancelEveryWayMovesPointsRigidly) {
  const double side = 0.02;
  const std::vector<Vector3d> nodes{{side, 0, 0}, {0, side, 0}, {-side, 0, 0}, {0, -side, 0}};
  const Vector3d moved(0.1, 0.2, 3);
  std::vector<DualQuaternion> transforms;
  for (const Vector3d& node : nodes) {
    const Vector3d axis = node / side;
    transforms.push_back(DualQuaternion::from(Eigen::Quaterniond(0, axis.x(), axis.y(), axis.z()), moved));
  }
  const Scene s(nodes, transforms);
  std::vector<Vector3d> points(16, Vector3d::Zero());
  for (int i = 0; i < 16; ++i) points[static_cast<std::size_t>(i)].z() = 0.005 * (i - 8); // equally far from all nodes
  for (const auto& way : {by_warp, by_bulk_warp, by_layer_pose, by_lanes, by_hull}) {
    const Poses found = way(s, points);
    for (std::size_t i = 0; i < points.size(); ++i) {
      ASSERT_TRUE(found[i]);
      EXPECT_NEAR((found[i]->point - moved).norm(), points[i].norm(), 1e-6);
      EXPECT_NEAR(found[i]->vector.norm(), 1, 1e-6);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Sets, SkinningAgreement, every_instruction_set(), name_of_set);

} // namespace
} // namespace kinora::motion
