#include "tracking/deforming_problem.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/parallel.h"

namespace kinora::tracking {
namespace {

constexpr std::size_t kPointsPerChunk = 512;
constexpr std::size_t kNodesPerChunk = 16;
constexpr std::size_t kEdgesPerChunk = 1024;
constexpr double kNearest = 0.05; // metres before the camera

double huber(double value, double bend) {
  const double size = std::abs(value);
  return size <= bend ? 0.5 * value * value : bend * (size - 0.5 * bend);
}

double huber_weight(double value, double bend) {
  const double size = std::abs(value);
  return size <= bend ? 1.0 : bend / size;
}

bool has_terms(const PointTerms& terms) {
  return terms.plane_scale != 0 || terms.texture_scale[0] != 0 || terms.texture_scale[1] != 0;
}

// Only blocks right of the diagonal were summed up; the others are their transposes.
void mirror_upper(const BlockPattern& pattern, BlockSystem& system) {
  for (std::size_t row = 0; row < pattern.node_count(); ++row) {
    for (std::size_t b = pattern.row_begin(row); b < pattern.row_end(row); ++b) {
      const int column = pattern.column(b);
      if (column >= static_cast<int>(row)) break;
      system.blocks[b] = system.blocks[pattern.find(column, static_cast<int>(row))].transpose();
    }
  }
}

} // namespace

DeformingProblem::DeformingProblem(const LayerModel& model, const ObjectView& view, const ProblemWeights& weights)
    : model_(model), view_(view), weights_(weights), terms_(model.points.size()) {}

// Which nodes share a point or an edge, and where in the system that is.
void DeformingProblem::tie_nodes() {
  point_uses_.resize(model_.nodes.size());
  edge_uses_.resize(model_.nodes.size());
  for (std::size_t p = 0; p < model_.points.size(); ++p) {
    const Influence& influence = model_.points[p].influence;
    for (std::size_t slot = 0; slot < static_cast<std::size_t>(influence.count); ++slot) {
      point_uses_[static_cast<std::size_t>(influence.nodes[slot])].push_back(
          {static_cast<std::uint32_t>(p), static_cast<std::uint32_t>(slot), {}});
    }
  }
  std::vector<BlockPattern::Pair> pairs;
  for (const GraphEdge& edge : model_.edges) pairs.push_back({edge.a, edge.b});
  std::vector<int> last(model_.nodes.size(), -1); // for each node, the last one that it was paired with
  for (std::size_t n = 0; n < model_.nodes.size(); ++n) {
    const int node = static_cast<int>(n);
    for (const PointUse& use : point_uses_[n]) {
      const Influence& influence = model_.points[use.point].influence;
      for (std::size_t k = 0; k < static_cast<std::size_t>(influence.count); ++k) {
        const int other = influence.nodes[k];
        if (other <= node || std::exchange(last[static_cast<std::size_t>(other)], node) == node) continue;
        pairs.push_back({node, other});
      }
    }
  }
  pattern_ = BlockPattern(model_.nodes.size(), pairs);
  std::vector<std::uint32_t> place(model_.nodes.size()); // of each node's block in a row
  for (std::size_t n = 0; n < model_.nodes.size(); ++n) {
    const std::size_t first = pattern_.row_begin(n);
    for (std::size_t b = first; b < pattern_.row_end(n); ++b) {
      place[static_cast<std::size_t>(pattern_.column(b))] = static_cast<std::uint32_t>(b - first);
    }
    for (PointUse& use : point_uses_[n]) {
      const Influence& influence = model_.points[use.point].influence;
      for (std::size_t k = 0; k < use.blocks.size(); ++k) {
        // Others are the transposes of some that are summed up there.
        const bool wanted = k < static_cast<std::size_t>(influence.count) && influence.nodes[k] >= static_cast<int>(n);
        use.blocks[k] = wanted ? place[static_cast<std::size_t>(influence.nodes[k])] : PointUse::kNone;
      }
    }
  }
  for (std::size_t e = 0; e < model_.edges.size(); ++e) {
    const GraphEdge& edge = model_.edges[e];
    edge_uses_[static_cast<std::size_t>(edge.a)].push_back(
        {static_cast<int>(e), static_cast<std::uint32_t>(pattern_.find(edge.a, edge.b))});
    edge_uses_[static_cast<std::size_t>(edge.b)].push_back(
        {static_cast<int>(e), static_cast<std::uint32_t>(pattern_.find(edge.b, edge.a))});
  }
}

DeformingProblem::PointResiduals DeformingProblem::residuals_at(std::size_t point, const Eigen::Vector3d& place) const {
  PointResiduals residuals;
  const PointTerms& terms = terms_[point];
  residuals.plane = terms.plane_scale * (terms.plane_normal.dot(place) + terms.plane_offset);
  if (place.z() < kNearest ||
      std::all_of(terms.texture_scale.begin(), terms.texture_scale.end(), [](double scale) { return scale == 0; })) {
    return residuals;
  }
  const double fx = view_.intrinsics.fx / place.z();
  const double fy = view_.intrinsics.fy / place.z();
  const TextureSample image =
      view_.sample_texture(level_, fx * place.x() + view_.intrinsics.cx, fy * place.y() + view_.intrinsics.cy);
  residuals.slope = Eigen::Vector3d(image.du * fx, image.dv * fy,
                                    -(image.du * fx * place.x() + image.dv * fy * place.y()) / place.z());
  for (std::size_t t = 0; t < PointTerms::kTextures; ++t) {
    if (terms.texture_scale[t] == 0) continue;
    residuals.textures[t] = terms.texture_scale[t] * (image.value - terms.expected[t]);
  }
  return residuals;
}

double DeformingProblem::energy_of(const PointResiduals& residuals) const {
  double sum = huber(residuals.plane, weights_.huber);
  for (const double value : residuals.textures) sum += huber(value, weights_.huber);
  return sum;
}

std::size_t DeformingProblem::rows_of(std::size_t point, const PointResiduals& residuals,
                                      std::array<PointRow, kRows>& rows) const {
  const PointTerms& terms = terms_[point];
  std::size_t count = 0;
  if (terms.plane_scale > 0) {
    const double root = std::sqrt(huber_weight(residuals.plane, weights_.huber));
    rows[count++] = {root * residuals.plane, root * terms.plane_scale * terms.plane_normal};
  }
  double information = 0;
  double sum = 0;
  for (std::size_t t = 0; t < PointTerms::kTextures; ++t) {
    const double weighted = huber_weight(residuals.textures[t], weights_.huber) * terms.texture_scale[t];
    information += weighted * terms.texture_scale[t];
    sum += weighted * residuals.textures[t];
  }
  if (information > 0 && !residuals.slope.isZero(0)) {
    const double root = std::sqrt(information);
    rows[count++] = {sum / root, root * residuals.slope};
  }
  return count;
}

// Where `from` would have its neighbour `to`, less where it is.
Eigen::Vector3d DeformingProblem::edge_residual(int from, int to, const NodeStates& states) const {
  const auto i = static_cast<std::size_t>(from);
  const auto j = static_cast<std::size_t>(to);
  return states.positions[i] + states.transforms[i].real._transformVector(model_.nodes[j] - model_.nodes[i]) -
         states.positions[j];
}

double DeformingProblem::energy(const LayerPose& pose) const {
  std::vector<double> parts(chunk_count(model_.points.size(), kPointsPerChunk));
  parallel_for(model_.points.size(), kPointsPerChunk, [&](const Chunk& chunk) {
    for (std::size_t p = chunk.begin; p < chunk.end; ++p) {
      if (has_terms(terms_[p])) parts[chunk.index] += energy_of(residuals_at(p, pose.places[p]));
    }
  });
  return std::accumulate(parts.begin(), parts.end(), 0.0) + energy_beside_points(pose.nodes);
}

double DeformingProblem::energy_beside_points(const NodeStates& states) const {
  std::vector<double> parts(chunk_count(model_.edges.size(), kEdgesPerChunk));
  parallel_for(model_.edges.size(), kEdgesPerChunk, [&](const Chunk& chunk) {
    for (std::size_t e = chunk.begin; e < chunk.end; ++e) {
      const auto [a, b] = model_.edges[e];
      for (const Eigen::Vector3d& residual : {edge_residual(a, b, states), edge_residual(b, a, states)}) {
        parts[chunk.index] += huber(residual.norm() / weights_.rigidity_sigma, weights_.huber);
      }
    }
  });
  return std::accumulate(parts.begin(), parts.end(), 0.0) + pull_energy(prior_, states) + pull_energy(binding_, states);
}

double DeformingProblem::pull_energy(std::span<const NodePull> pulls, const NodeStates& states) const {
  double sum = 0;
  for (std::size_t i = 0; i < pulls.size(); ++i) {
    sum += huber(pulls[i].scale * (states.positions[i] - pulls[i].place).norm(), weights_.huber);
  }
  return sum;
}

void DeformingProblem::set_prior(const NodeStates& prior) {
  prior_.clear();
  for (const Eigen::Vector3d& place : prior.positions) prior_.push_back({place, 1 / weights_.prior_sigma});
}

BlockSystem DeformingProblem::linearise(const LayerPose& pose, double& energy) {
  const NodeStates& states = pose.nodes;
  if (point_uses_.empty()) tie_nodes();
  if (!jacobians_) jacobians_ = std::make_unique_for_overwrite<PointJacobians[]>(model_.points.size());
  std::vector<double> parts(chunk_count(model_.points.size(), kPointsPerChunk));
  parallel_for(model_.points.size(), kPointsPerChunk, [&](const Chunk& chunk) {
    std::array<PointRow, kRows> rows;
    for (std::size_t p = chunk.begin; p < chunk.end; ++p) {
      PointJacobians& out = jacobians_[p];
      out.empty = !has_terms(terms_[p]);
      if (out.empty) continue;
      const SkinnedPoint& point = model_.points[p];
      const Eigen::Vector3d& place = pose.places[p];
      const PointResiduals residuals = residuals_at(p, place);
      parts[chunk.index] += energy_of(residuals);
      const std::size_t count = rows_of(p, residuals, rows);
      out.empty = count == 0;
      for (std::size_t r = count; r < kRows; ++r) rows[r] = {0, Eigen::Vector3d::Zero()};
      for (std::size_t r = 0; r < kRows; ++r) out.residuals[r] = static_cast<float>(rows[r].residual);
      for (std::size_t k = 0; k < static_cast<std::size_t>(point.influence.count); ++k) {
        const NodePart part(states, point.influence, pose.motions[p], k);
        for (std::size_t r = 0; r < kRows; ++r) {
          const Eigen::Vector3d& gradient = rows[r].gradient;
          PointJacobians::Row& row = out.by_node[k][r];
          row.fill(0);
          Eigen::Map<Eigen::Matrix<float, 6, 1>>(row.data()) =
              part.pulled_back(gradient, place.cross(gradient)).cast<float>();
        }
      }
    }
  });
  energy = std::accumulate(parts.begin(), parts.end(), 0.0) + energy_beside_points(states);
  BlockSystem system;
  system.blocks.assign(pattern_.block_count(), Block::Zero());
  system.gradient.assign(model_.nodes.size(), Twist::Zero());
  parallel_for(model_.nodes.size(), kNodesPerChunk, [&](const Chunk& chunk) {
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      add_points(i, system);
      add_edges(i, states, system);
      if (!prior_.empty()) add_pull(i, prior_[i], states, system);
      if (!binding_.empty()) add_pull(i, binding_[i], states, system);
    }
  });
  mirror_upper(pattern_, system);
  return system;
}

// In single precision: a node has few hundred points.
void DeformingProblem::add_points(std::size_t node, BlockSystem& system) const {
  const std::size_t first = pattern_.row_begin(node);
  std::vector<PaddedBlock> sums(pattern_.row_end(node) - first);
  PointJacobians::Row gradient{};
  add_point_products(point_uses_[node], {jacobians_.get(), model_.points.size()}, sums, gradient);
  system.gradient[node] += Eigen::Map<const Eigen::Matrix<float, 6, 1>>(gradient.data()).cast<double>();
  for (std::size_t b = 0; b < sums.size(); ++b) {
    for (std::size_t c = 0; c < sums[b].size(); ++c) {
      system.blocks[first + b].col(static_cast<Eigen::Index>(c)) +=
          Eigen::Map<const Eigen::Matrix<float, 6, 1>>(sums[b][c].data()).cast<double>();
    }
  }
}

// An edge (i, j) has two residuals: T_i x_j − c_j, with derivatives (1, −[T_i x_j − c_i]×) by i and −1 by j; and the
// same the other way round.
void DeformingProblem::add_edges(std::size_t node, const NodeStates& states, BlockSystem& system) const {
  const std::size_t diagonal = pattern_.find(static_cast<int>(node), static_cast<int>(node));
  const double information = 1 / (weights_.rigidity_sigma * weights_.rigidity_sigma);
  for (const EdgeUse& use : edge_uses_[node]) {
    const GraphEdge& edge = model_.edges[static_cast<std::size_t>(use.edge)];
    const int own = static_cast<int>(node);
    const int other = edge.a == own ? edge.b : edge.a;
    for (const bool outward : {true, false}) {
      const int from = outward ? own : other;
      const int to = outward ? other : own;
      const Eigen::Vector3d residual = edge_residual(from, to, states);
      const double weight = information * huber_weight(residual.norm() / weights_.rigidity_sigma, weights_.huber);
      const Eigen::Vector3d lever =
          residual + states.positions[static_cast<std::size_t>(to)] - states.positions[static_cast<std::size_t>(from)];
      const Eigen::Matrix3d turn = weight * skew(lever);
      Block& own_block = system.blocks[diagonal];
      own_block.diagonal().head<3>().array() += weight;
      system.gradient[node].head<3>() += (outward ? weight : -weight) * residual;
      if (outward) {
        own_block.topRightCorner<3, 3>() -= turn;
        own_block.bottomLeftCorner<3, 3>() += turn;
        own_block.bottomRightCorner<3, 3>() -= weight * lever * lever.transpose();
        own_block.diagonal().tail<3>().array() += weight * lever.squaredNorm();
        system.gradient[node].tail<3>() += weight * lever.cross(residual);
      }
      if (other < own) continue;
      Block& between = system.blocks[use.block];
      between.diagonal().head<3>().array() -= weight;
      if (outward) {
        between.bottomLeftCorner<3, 3>() -= turn;
      } else {
        between.topRightCorner<3, 3>() += turn;
      }
    }
  }
}

void DeformingProblem::add_pull(std::size_t node, const NodePull& pull, const NodeStates& states,
                                BlockSystem& system) const {
  const Eigen::Vector3d off = states.positions[node] - pull.place;
  const double weight = huber_weight(pull.scale * off.norm(), weights_.huber) * pull.scale * pull.scale;
  const std::size_t diagonal = pattern_.find(static_cast<int>(node), static_cast<int>(node));
  system.blocks[diagonal].diagonal().head<3>().array() += weight;
  system.gradient[node].head<3>() += weight * off;
}

void DeformingProblem::linearise_rigid(const LayerPose& pose, const Eigen::Vector3d& pivot, Block& information,
                                       Twist& gradient) const {
  struct Part {
    Block information = Block::Zero();
    Twist gradient = Twist::Zero();
  };
  std::vector<Part> parts(chunk_count(model_.points.size(), kPointsPerChunk));
  parallel_for(model_.points.size(), kPointsPerChunk, [&](const Chunk& chunk) {
    std::array<PointRow, kRows> rows;
    for (std::size_t p = chunk.begin; p < chunk.end; ++p) {
      if (!has_terms(terms_[p])) continue;
      const Eigen::Vector3d& place = pose.places[p];
      const std::size_t count = rows_of(p, residuals_at(p, place), rows);
      for (std::size_t r = 0; r < count; ++r) {
        Twist row;
        row << rows[r].gradient, (place - pivot).cross(rows[r].gradient);
        parts[chunk.index].information.noalias() += row * row.transpose();
        parts[chunk.index].gradient += rows[r].residual * row;
      }
    }
  });
  information.setZero();
  gradient.setZero();
  for (const Part& part : parts) {
    information += part.information;
    gradient += part.gradient;
  }
}

} // namespace kinora::tracking
