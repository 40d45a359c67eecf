#include "encode/pose_refinement.h"

#include <cmath>

#include <Eigen/Cholesky>

#include "core/parallel.h"

namespace kinora::encode {
namespace {

using fields::RayResponse;

constexpr double kMaxDeviations = 3; // beyond so many a residual pulls no harder

void evaluate(FieldView& view, const SE3& canonical_from_world, bool jacobian) {
  const fields::Rotation rotation = fields::rotation_of(canonical_from_world.linear().transpose());
  view.evaluate(jacobian, [&](std::span<const FieldView::Ray> rays, fields::CanonicalRay* canonical) {
    for (std::size_t k = 0; k < rays.size(); ++k) {
      canonical[k] = {canonical_from_world * rays[k].point,
                      canonical_from_world.linear() * rays[k].direction,
                      {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()},
                      rays[k].reach,
                      rays[k].direction.norm(),
                      rotation};
    }
  });
}

/// Normal equations of a small motion of the rays in canonical space, a turn about a centre, then a shift, and of the
/// times that reading colour and depth takes.
struct System {
  static constexpr int kPose = 6;
  static constexpr int kTimes = 2;
  static constexpr int kUnknowns = kPose + kTimes;
  Eigen::Matrix<double, kUnknowns, kUnknowns> hessian = Eigen::Matrix<double, kUnknowns, kUnknowns>::Zero();
  Eigen::Matrix<double, kUnknowns, 1> gradient = Eigen::Matrix<double, kUnknowns, 1>::Zero();

  auto pose() const { return hessian.topLeftCorner<kPose, kPose>().ldlt(); }

  /// What is left for the times when the pose is free (the Schur complement).
  ReadoutEvidence readout() const {
    const Eigen::Matrix<double, kPose, kTimes> both = hessian.topRightCorner<kPose, kTimes>();
    const Eigen::Matrix<double, kPose, kTimes> solved = pose().solve(both);
    return {hessian.bottomRightCorner<kTimes, kTimes>() - both.transpose() * solved,
            gradient.tail<kTimes>() - solved.transpose() * gradient.head<kPose>()};
  }
};

System linearised(const FieldView& view, double color_sigma, const Eigen::Vector3d& centre,
                  const SE3& canonical_from_camera, const Twist& velocity) {
  System system;
  const SE3 to_camera = canonical_from_camera.inverse();
  for (std::size_t i = 0; i < view.size(); ++i) {
    if (!view.position(i).allFinite()) continue;
    const Eigen::Vector3d arm = view.position(i) - centre;
    const Eigen::Vector3d shift = velocity.head<3>() + velocity.tail<3>().cross(to_camera * view.position(i));
    const Eigen::Vector3d per_second = canonical_from_camera.linear() * (view.time(i) * shift);
    for (std::size_t v = 0; v < RayResponse::kValues; ++v) {
      const auto residual = view.residual(i, v);
      if (!residual) continue;
      const Eigen::Vector3d& slope = view.gradient(i, v);
      const double weight = view.weight(i, v, color_sigma);
      const double deviations = std::abs(*residual * weight);
      const double robust = deviations > kMaxDeviations ? kMaxDeviations / deviations : 1; // Huber
      const bool of_depth = v == RayResponse::kDepth;
      Eigen::Matrix<double, System::kUnknowns, 1> row;
      row << slope, arm.cross(slope), of_depth ? 0 : per_second.dot(slope), of_depth ? per_second.dot(slope) : 0;
      system.hessian.noalias() += robust * weight * weight * row * row.transpose();
      system.gradient += robust * weight * weight * *residual * row;
    }
  }
  return system;
}

std::optional<PoseCorrection> refined(const fields::Field& field, const fields::LayerObservations& layer,
                                      const fields::StoredFrame& frame, const Twist& velocity,
                                      const PoseRefinementConfig& config) {
  FieldView view(field, layer, frame);
  const SE3 first = layer.motion.canonical_to_world(frame.frame).inverse();
  const Eigen::Vector3d centre = field.config.box.origin + Eigen::Vector3d::Constant(field.config.box.side / 2);
  SE3 moved = SE3::Identity(); // of the rays in canonical space
  SE3 best = moved;
  double best_cost = 0, first_sigma = 0, best_sigma = 0;
  ReadoutEvidence readout;
  bool is_moved = false;
  for (int round = 0; round <= config.rounds; ++round) {
    evaluate(view, moved * first, round < config.rounds);
    const auto sigma = view.color_sigma();
    if (!sigma) return std::nullopt;
    if (round == 0) first_sigma = *sigma;
    const double now = view.cost(first_sigma);
    if (round > 0 && !(now < best_cost)) break;
    is_moved = round > 0;
    best = moved;
    best_cost = now;
    best_sigma = *sigma;
    if (round == config.rounds) break;
    System system = linearised(view, *sigma, centre, moved * first * frame.camera.camera_to_world, velocity);
    Twist prior; // one over variances
    prior << Eigen::Vector3d::Constant(1 / (config.prior_metres * config.prior_metres)),
        Eigen::Vector3d::Constant(1 / (config.prior_radians * config.prior_radians));
    system.hessian.diagonal().head<System::kPose>() += prior;
    readout = system.readout();
    const Twist step = -system.pose().solve(system.gradient.head<System::kPose>());
    if (!step.allFinite()) break;
    moved = SE3(Eigen::Translation3d(centre)) * exp_se3(step) * SE3(Eigen::Translation3d(-centre)) * moved;
  }
  if (!is_moved) return std::nullopt;
  return PoseCorrection{best * first * frame.camera.camera_to_world, {first_sigma, best_sigma}, readout};
}

} // namespace

std::vector<std::optional<PoseCorrection>> refine_poses(const fields::Field& field,
                                                        const fields::LayerObservations& layer,
                                                        std::span<const Twist> velocities, Progress& progress,
                                                        const PoseRefinementConfig& config) {
  const std::vector<fields::StoredFrame>& frames = layer.pixels.frames();
  std::vector<std::optional<PoseCorrection>> corrections(frames.size());
  constexpr std::size_t kAtOnce = 8;
  for (std::size_t begin = 0; begin < frames.size(); begin += kAtOnce) {
    const std::size_t count = std::min(kAtOnce, frames.size() - begin);
    parallel_for(count, 1, [&](const Chunk& chunk) {
      progress.check();
      const fields::StoredFrame& frame = frames[begin + chunk.index];
      if (!layer.is_lost(frame))
        corrections[begin + chunk.index] =
            refined(field, layer, frame, velocities[static_cast<std::size_t>(frame.frame)], config);
    });
    progress.advance(begin + count, "");
  }
  return corrections;
}

} // namespace kinora::encode
