#include "encode/motion_refinement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "core/damped_gauss_newton.h"
#include "core/parallel.h"
#include "encode/field_view.h"
#include "encode/node_correction.h"
#include "motion/bulk_warp.h"
#include "tracking/solver/deforming_problem.h"
#include "tracking/solver/pcg.h"

namespace kinora::encode {
namespace {

using fields::RayResponse;
using motion::BulkWarp;
using motion::NodeStates;

constexpr int kDampingAttempts = 5; // of a step, each damped thirty times as much

std::array<float, 3> to_array(const Eigen::Vector3d& v) {
  const Eigen::Vector3f single = v.cast<float>();
  return {single.x(), single.y(), single.z()};
}

Eigen::Vector3d to_vector(const std::array<float, 3>& v) { return Eigen::Vector3f(v.data()).cast<double>(); }

/// What the field shows in a view, for any states of the nodes.
void evaluate(FieldView& view, const BulkWarp& warp, bool jacobian) {
  view.evaluate(jacobian, [&](std::span<const FieldView::Ray> rays, fields::CanonicalRay* canonical) {
    std::vector<BulkWarp::Ray> world;
    for (const FieldView::Ray& ray : rays)
      world.push_back(
          {to_array(ray.point - warp.world_origin()), to_array(ray.direction), static_cast<float>(ray.reach), 0});
    std::vector<BulkWarp::CanonicalRay> back(rays.size());
    warp.to_canonical(world, back.data());
    for (std::size_t k = 0; k < rays.size(); ++k) {
      canonical[k] = {to_vector(back[k].point) + warp.canonical_origin(),
                      to_vector(back[k].direction),
                      {to_vector(back[k].curvatures[0]), to_vector(back[k].curvatures[1])},
                      rays[k].reach,
                      rays[k].direction.norm(),
                      back[k].rotation};
    }
  });
}

/// Refines any frame, from any thread.
class Refiner {
public:
  Refiner(const fields::Field& field, const fields::LayerObservations& layer,
          std::span<const tracking::GraphEdge> edges, double node_spacing, const MotionRefinementConfig& config)
      : field_(field), layer_(layer), graph_(layer.motion.graph()),
        table_(std::make_shared<const motion::InfluenceTable>(graph_)), edges_(edges), spacing_(node_spacing),
        config_(config) {
    for (const Eigen::Vector3d& node : graph_->nodes()) nodes_.emplace_back(node - table_->origin());
  }

  /// Nothing if no node was moved.
  std::optional<ColorFit> refine(const fields::StoredFrame& frame, std::vector<DualQuaternion>& nodes) const {
    FieldView view(field_, layer_, frame);
    std::vector<DualQuaternion> best = nodes;
    double best_cost = 0;
    double first_sigma = 0;
    double best_sigma = 0;
    bool moved = false;
    for (int round = 0; round <= config_.rounds; ++round) {
      const BulkWarp warp(table_, motion::Warp(graph_, nodes));
      evaluate(view, warp, round == 0);
      const auto sigma = view.color_sigma();
      if (!sigma) break;
      if (round == 0) first_sigma = *sigma;
      const double now = view.cost(first_sigma);
      if (round > 0 && !(now < best_cost)) break;
      moved = round > 0;
      best = nodes;
      best_cost = now;
      best_sigma = *sigma;
      if (round < config_.rounds && !step(view, warp, *sigma, nodes)) break;
    }
    nodes = std::move(best);
    if (!moved) return std::nullopt;
    return ColorFit{first_sigma, best_sigma};
  }

private:
  // The nodes' transforms between coordinates relative to the warp's origins.
  NodeStates states_of(const std::vector<DualQuaternion>& nodes, const BulkWarp& warp) const {
    NodeStates states;
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      const SE3 relative(Eigen::Translation3d(-warp.world_origin()) * nodes[n].to_se3() *
                         Eigen::Translation3d(table_->origin()));
      states.push_back(DualQuaternion::from(relative), nodes_[n]);
    }
    return states;
  }

  // Where a layer moves, its canonical space moves the other way beneath the ray: each residual is linear in the place
  // of the surface point, as that of a plane.
  void add_rows(const FieldView& view, const NodeStates& states, double color_sigma,
                std::vector<motion::SkinnedPoint>& points, std::vector<tracking::DataTerm>& terms) const {
    for (std::size_t i = 0; i < view.size(); ++i) {
      if (!view.position(i).allFinite()) continue;
      const motion::Influence influence = graph_->influence(view.position(i));
      if (influence.count == 0) continue;
      const motion::BlendedMotion blended = motion::blend_motion(states, influence);
      const Eigen::Vector3d canonical = view.position(i) - table_->origin();
      const Eigen::Vector3d position = blended.apply(canonical);
      for (std::size_t v = 0; v < RayResponse::kValues; ++v) {
        const auto residual = view.residual(i, v);
        const Eigen::Vector3d gradient = -blended.rotate(view.gradient(i, v));
        const double length = gradient.norm();
        if (!residual || !(length > 1e-6)) continue;
        tracking::DataTerm term;
        term.plane_normal = (gradient / length).cast<float>();
        term.plane_offset = static_cast<float>((*residual - gradient.dot(position)) / length);
        term.plane_scale = static_cast<float>(length * view.weight(i, v, color_sigma));
        points.emplace_back(canonical.cast<float>(), Eigen::Vector3f::UnitZ(), influence);
        terms.push_back(term);
      }
    }
  }

  // One damped Gauss–Newton step; false if none lowers the energy.
  bool step(const FieldView& view, const BulkWarp& warp, double color_sigma, std::vector<DualQuaternion>& nodes) const {
    const NodeStates states = states_of(nodes, warp);
    std::vector<motion::SkinnedPoint> points;
    std::vector<tracking::DataTerm> terms;
    add_rows(view, states, color_sigma, points, terms);
    const tracking::LayerView no_textures;
    tracking::DeformingProblem problem({nodes_, edges_, points}, no_textures,
                                       {config_.rigidity * spacing_, config_.prior_sigma});
    problem.terms() = std::move(terms);
    problem.set_prior(states);
    double before = 0;
    const tracking::BlockSystem system = problem.linearise(motion::pose_layer(points, states), before);
    MarquardtDamping damping({.growth = 30});
    return damped_gauss_newton(damping, kDampingAttempts, [&](double value) -> StepOutcome {
      const auto added = tracking::damping_of(problem.pattern(), system, value, 1e-6);
      const auto solved =
          tracking::solve_pcg(problem.pattern(), system, added, config_.pcg_iterations, config_.pcg_tolerance);
      const NodeStates candidate = motion::stepped(states, solved.step);
      if (!(problem.energy(motion::pose_layer(points, candidate)) < before)) return {};
      for (std::size_t n = 0; n < nodes.size(); ++n) {
        nodes[n] =
            DualQuaternion::from(SE3(Eigen::Translation3d(warp.world_origin()) * candidate.transforms[n].to_se3() *
                                     Eigen::Translation3d(-table_->origin())));
      }
      return {.is_taken = true, .is_last = true};
    });
  }

  const fields::Field& field_;
  fields::LayerObservations layer_;
  std::shared_ptr<const motion::DeformationGraph> graph_;
  std::shared_ptr<const motion::InfluenceTable> table_;
  std::span<const tracking::GraphEdge> edges_;
  double spacing_;
  MotionRefinementConfig config_;
  std::vector<Eigen::Vector3d> nodes_; ///< canonical, relative to the table's origin
};

// Half way between what the tracker says of a node and what the frames beside say, which errs in other ways; less of
// theirs where they differ by more than the tracker errs: there the node changed its pace.
DualQuaternion smoothed(const Eigen::Vector3d& node, const DualQuaternion& tracked, const DualQuaternion& before,
                        const DualQuaternion& after) {
  constexpr double kTrackerSigma = 0.005; // metres
  const DualQuaternion between = blend(std::array{before, after}, std::array{0.5, 0.5});
  const double off = (between.to_se3() * node - tracked.to_se3() * node).norm() / kTrackerSigma;
  const double share = 0.5 / (1 + off * off);
  return blend(std::array{tracked, between}, std::array{1 - share, share});
}

// A frame that was not refined, next to ones that were, is corrected as these are in the mean.
void correct_others(const motion::Motion& motion, const std::vector<bool>& is_refined,
                    std::vector<motion::Motion::Deformation>& refined) {
  const std::vector<Eigen::Vector3d>& nodes = motion.graph()->nodes();
  for (std::size_t f = 0; f < refined.size(); ++f) {
    if (is_refined[f] || refined[f].health != motion::Health::kTracked) continue;
    std::vector<std::size_t> neighbours;
    if (f > 0 && is_refined[f - 1]) neighbours.push_back(f - 1);
    if (f + 1 < refined.size() && is_refined[f + 1]) neighbours.push_back(f + 1);
    if (neighbours.empty()) continue;
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      Twist mean = Twist::Zero();
      for (const std::size_t g : neighbours) {
        mean += correction_of(nodes[n], motion.deformations()[g].node_to_world[n], refined[g].node_to_world[n]) /
                static_cast<double>(neighbours.size());
      }
      DualQuaternion& node = refined[f].node_to_world[n];
      node = corrected(nodes[n], node, mean);
      if (neighbours.size() == 2) {
        node = smoothed(nodes[n], node, refined[f - 1].node_to_world[n], refined[f + 1].node_to_world[n]);
      }
    }
  }
}

} // namespace

motion::Motion refine_motion(const fields::Field& field, const fields::LayerObservations& layer,
                             std::span<const tracking::GraphEdge> edges, double node_spacing, Progress& progress,
                             MotionRefinement* report, const MotionRefinementConfig& config) {
  const Refiner refiner(field, layer, edges, node_spacing, config);
  const motion::Motion& motion = layer.motion;
  const std::vector<fields::StoredFrame>& frames = layer.pixels.frames();
  std::vector<motion::Motion::Deformation> refined = motion.deformations();
  std::vector<bool> is_refined(refined.size(), false);
  // Frames do not know of each other: some side by side leave no thread waiting where one alone would.
  constexpr std::size_t kAtOnce = 8;
  std::vector<std::optional<ColorFit>> fits(frames.size());
  for (std::size_t begin = 0; begin < frames.size(); begin += kAtOnce) {
    const std::size_t count = std::min(kAtOnce, frames.size() - begin);
    parallel_for(count, 1, [&](const Chunk& chunk) {
      progress.check();
      const std::size_t k = begin + chunk.index;
      motion::Motion::Deformation& deformation = refined[static_cast<std::size_t>(frames[k].frame)];
      if (deformation.health == motion::Health::kTracked)
        fits[k] = refiner.refine(frames[k], deformation.node_to_world);
    });
    progress.advance(begin + count, "");
  }
  MotionRefinement result;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    if (!fits[k]) continue;
    is_refined[static_cast<std::size_t>(frames[k].frame)] = true;
    ++result.frames;
    result.color_before += fits[k]->before;
    result.color_after += fits[k]->after;
  }
  correct_others(motion, is_refined, refined);
  if (result.frames > 0) {
    result.color_before /= static_cast<double>(result.frames);
    result.color_after /= static_cast<double>(result.frames);
  }
  if (report != nullptr) *report = result;
  return motion::Motion::deforming(motion.graph(), std::move(refined));
}

} // namespace kinora::encode
