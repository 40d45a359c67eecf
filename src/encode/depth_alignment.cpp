#include "encode/depth_alignment.h"

#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

#include "tracking/deforming/deforming_alignment.h"

namespace kinora::encode {
namespace {

using motion::NodeStates;

constexpr int kMaxPoints = 6000;
// How far a guess from the frames beside is off: 5 m/s² over two intervals of 33 ms are 5 mm.
constexpr double kGuessMetres = 0.01;
constexpr double kGuessRadians = 0.05;

/// What is seen of a layer at the guess, as the solver has it: all relative to the origin, canonical.
struct VisibleSurface {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> nodes;
  std::vector<motion::SkinnedPoint> points;
  NodeStates states; ///< of the guess, canonical to camera
};

std::vector<DualQuaternion> transforms_of(const motion::Warp& warp) {
  if (warp.is_rigid()) return {DualQuaternion::from(warp.rigid())};
  return warp.node_to_world();
}

struct CanonicalPoint {
  Eigen::Vector3d position;
  Eigen::Vector3d normal;
  motion::Influence influence;
};

std::vector<CanonicalPoint> canonical_points(const fields::Picture& drawn, const Camera& camera,
                                             const motion::Warp& guess) {
  const DepthImage& depth = drawn.depth;
  int visible = 0;
  for (const float metres : depth.values()) visible += metres > 0 ? 1 : 0;
  const int stride = std::max(1, static_cast<int>(std::ceil(std::sqrt(static_cast<double>(visible) / kMaxPoints))));
  std::vector<CanonicalPoint> points;
  for (int v = stride / 2; v < depth.height(); v += stride) {
    for (int u = stride / 2; u < depth.width(); u += stride) {
      if (!(depth.at(u, v) > 0)) continue;
      const Eigen::Vector3d world = camera.camera_to_world * camera.intrinsics.unproject(u, v, depth.at(u, v));
      const auto canonical = guess.is_rigid() ? std::optional<Eigen::Vector3d>(guess.rigid().inverse() * world)
                                              : guess.to_canonical(world);
      if (!canonical) continue;
      motion::Influence influence;
      if (guess.is_rigid()) {
        influence.count = 1;
        influence.weights[0] = 1;
      } else {
        influence = guess.graph()->influence(*canonical);
      }
      const auto transform = guess.is_rigid() ? std::optional<SE3>(guess.rigid()) : guess.at(*canonical);
      if (influence.count == 0 || !transform) continue;
      const Eigen::Vector3d normal(drawn.normal.at(u, v, 0), drawn.normal.at(u, v, 1), drawn.normal.at(u, v, 2));
      points.push_back(
          {*canonical, transform->linear().transpose() * camera.camera_to_world.linear() * normal, influence});
    }
  }
  return points;
}

VisibleSurface visible_surface(const fields::Picture& drawn, const Camera& camera, const motion::Warp& guess) {
  const std::vector<CanonicalPoint> points = canonical_points(drawn, camera, guess);
  VisibleSurface surface;
  if (points.empty()) return surface;
  for (const CanonicalPoint& point : points) surface.origin += point.position / static_cast<double>(points.size());
  if (guess.is_rigid()) {
    surface.nodes.emplace_back(Eigen::Vector3d::Zero());
  } else {
    for (const Eigen::Vector3d& node : guess.graph()->nodes()) surface.nodes.emplace_back(node - surface.origin);
  }
  for (const CanonicalPoint& point : points) {
    surface.points.emplace_back((point.position - surface.origin).cast<float>(), point.normal.cast<float>(),
                                point.influence);
  }
  const SE3 world_to_camera = camera.camera_to_world.inverse();
  const std::vector<DualQuaternion> transforms = transforms_of(guess);
  for (std::size_t n = 0; n < transforms.size(); ++n) {
    surface.states.push_back(SE3(world_to_camera * transforms[n].to_se3() * Eigen::Translation3d(surface.origin)),
                             surface.nodes[n]);
  }
  return surface;
}

motion::Warp warp_of(const VisibleSurface& surface, const NodeStates& states, const Camera& camera,
                     const motion::Warp& guess) {
  std::vector<DualQuaternion> transforms;
  for (const DualQuaternion& state : states.transforms) {
    transforms.push_back(DualQuaternion::from(
        renormalized(SE3(camera.camera_to_world * state.to_se3() * Eigen::Translation3d(-surface.origin)))));
  }
  if (guess.is_rigid()) return motion::Warp(transforms.front().to_se3());
  const auto* graph = guess.graph();
  return motion::Warp(std::make_shared<const motion::DeformationGraph>(*graph), std::move(transforms));
}

/// Brings one rigid thing nearer to the view by Gauss–Newton; the guess counts as measured, too, so that nothing slides
/// along what depth does not see.
class RigidAlignment {
public:
  RigidAlignment(const VisibleSurface& surface, const tracking::LayerModel& model,
                 std::span<const tracking::PointTexture> textures, const tracking::LayerView& view,
                 const tracking::DeformingAlignmentConfig& config)
      : surface_(surface), model_(model), textures_(textures), view_(view), config_(config) {}

  NodeStates solve() const {
    constexpr int kSteps = 5; // for each gate
    const Eigen::Vector3d pivot = surface_.states.positions.front();
    SE3 motion = SE3::Identity(); // of the camera's space about the pivot
    tracking::DeformingProblem problem(model_, view_, {});
    for (const double gate : config_.gates) {
      for (int i = 0; i < kSteps; ++i) {
        const motion::LayerPose pose = motion::pose_layer(model_.points, moved_about(pivot, motion));
        associate(model_, textures_, view_, pose, 0, gate, config_, problem.terms());
        tracking::Matrix6d information;
        Twist gradient;
        problem.linearise_rigid(pose, pivot, information, gradient);
        // Neighbouring pixels are not independent.
        constexpr double kShare = 0.1;
        Twist weights;
        weights << Eigen::Vector3d::Constant(1 / (kGuessMetres * kGuessMetres)),
            Eigen::Vector3d::Constant(1 / (kGuessRadians * kGuessRadians));
        information = kShare * information;
        information.diagonal() += weights;
        const Twist step = information.ldlt().solve(-(kShare * gradient + weights.cwiseProduct(log_se3(motion))));
        if (!step.allFinite()) return surface_.states;
        motion = renormalized(exp_se3(step) * motion);
      }
    }
    return moved_about(pivot, motion);
  }

private:
  NodeStates moved_about(const Eigen::Vector3d& pivot, const SE3& motion) const {
    return motion::moved(surface_.states, SE3(Eigen::Translation3d(pivot) * motion * Eigen::Translation3d(-pivot)));
  }

  const VisibleSurface& surface_;
  const tracking::LayerModel& model_;
  std::span<const tracking::PointTexture> textures_;
  const tracking::LayerView& view_;
  const tracking::DeformingAlignmentConfig& config_;
};

} // namespace

std::optional<motion::Warp> align_by_depth(const fields::Picture& drawn, const Camera& camera,
                                           const motion::Warp& guess, const LayerStiffness& stiffness,
                                           const tracking::LayerView& view) {
  constexpr std::size_t kMinPoints = 60;
  if (view.empty()) return std::nullopt;
  const VisibleSurface surface = visible_surface(drawn, camera, guess);
  if (surface.points.size() < kMinPoints) return std::nullopt;
  const tracking::LayerModel model{surface.nodes, stiffness.edges, surface.points};
  tracking::PointTexture unknown{};
  unknown.last.fill(std::numeric_limits<float>::quiet_NaN());
  unknown.fused = std::numeric_limits<float>::quiet_NaN();
  const std::vector<tracking::PointTexture> textures(surface.points.size(), unknown);
  tracking::DeformingAlignmentConfig config;
  config.prior_sigma = kGuessMetres;
  config.silhouette_weight = 0;
  const NodeStates aligned = guess.is_rigid() ? RigidAlignment(surface, model, textures, view, config).solve()
                                              : align_deforming(model, textures, view, surface.states, surface.states,
                                                                stiffness.node_spacing, config)
                                                    .nodes;
  const tracking::DeformingQuality before = evaluate_deformation(model, textures, view, surface.states);
  const tracking::DeformingQuality after = evaluate_deformation(model, textures, view, aligned);
  constexpr double kMinInlierShare = 0.5;
  if (after.inliers < before.inliers || after.inlier_share() < kMinInlierShare) return std::nullopt;
  return warp_of(surface, aligned, camera, guess);
}

} // namespace kinora::encode
