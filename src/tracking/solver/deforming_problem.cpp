#include "tracking/solver/deforming_problem.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/parallel.h"

namespace kinora::tracking {
namespace {

constexpr std::size_t kPointsPerChunk = 1024;
constexpr std::size_t kNodesPerChunk = 16;

template <class Items> auto part_of(const Items& items, const Chunk& chunk) {
  return std::span(items).subspan(chunk.begin, chunk.end - chunk.begin);
}

// Only blocks right of the diagonal were summed up; the others are their transposes.
void symmetrise(const BlockPattern& pattern, BlockSystem& system) {
  parallel_for(pattern.node_count(), 4 * kNodesPerChunk, [&](const Chunk& chunk) {
    for (std::size_t row = chunk.begin; row < chunk.end; ++row) {
      for (std::size_t b = pattern.row_begin(row); b < pattern.diagonal(row); ++b) {
        system.blocks[b].matrix() = system.blocks[pattern.transposed(b)].matrix().transpose();
      }
    }
  });
}

} // namespace

DeformingProblem::DeformingProblem(const LayerModel& model, const LayerView& view, const ProblemWeights& weights)
    : model_(model), view_(view), weights_(weights), terms_(model.points.size()),
      edges_(rows_of(model.edges, model.nodes)) {}

// Which nodes share a point or an edge, and where in the system that is.
void DeformingProblem::find_pattern() {
  const std::size_t nodes = model_.nodes.size();
  point_incidences_begin_.assign(nodes + 1, 0);
  std::vector<std::uint8_t> counts(model_.points.size());
  for (std::size_t p = 0; p < model_.points.size(); ++p) {
    const motion::SkinnedPoint& point = model_.points[p];
    counts[p] = static_cast<std::uint8_t>(point.node_count());
    for (std::size_t slot = 0; slot < counts[p]; ++slot) {
      ++point_incidences_begin_[static_cast<std::size_t>(point.nodes[slot]) + 1];
    }
  }
  std::partial_sum(point_incidences_begin_.begin(), point_incidences_begin_.end(), point_incidences_begin_.begin());
  point_incidences_.resize(point_incidences_begin_.back());
  std::vector<std::size_t> next(point_incidences_begin_.begin(), point_incidences_begin_.end() - 1);
  for (std::size_t p = 0; p < model_.points.size(); ++p) {
    for (std::size_t slot = 0; slot < counts[p]; ++slot) {
      point_incidences_[next[static_cast<std::size_t>(model_.points[p].nodes[slot])]++] = {
          static_cast<std::uint32_t>(p), static_cast<std::uint32_t>(slot), {}};
    }
  }
  std::vector<std::vector<BlockPattern::Pair>> of_chunks(chunk_count(nodes, kNodesPerChunk));
  parallel_for(nodes, kNodesPerChunk, [&](const Chunk& chunk) {
    std::vector<std::size_t> last(nodes, nodes); // for each node, the last one that it was paired with
    for (std::size_t n = chunk.begin; n < chunk.end; ++n) {
      for (const PointIncidence& use : incidences_of(n)) {
        const motion::SkinnedPoint& point = model_.points[use.point];
        for (std::size_t k = 0; k < counts[use.point]; ++k) {
          const auto other = static_cast<std::size_t>(point.nodes[k]);
          if (other <= n || std::exchange(last[other], n) == n) continue;
          of_chunks[chunk.index].push_back({static_cast<int>(n), point.nodes[k]});
        }
      }
    }
  });
  std::vector<BlockPattern::Pair> pairs;
  for (const GraphEdge& edge : model_.edges) pairs.push_back({edge.a, edge.b});
  for (const auto& some : of_chunks) pairs.insert(pairs.end(), some.begin(), some.end());
  pattern_ = BlockPattern(nodes, pairs);
  parallel_for(nodes, kNodesPerChunk, [&](const Chunk& chunk) {
    std::vector<std::uint32_t> position(nodes); // of each node's block in a row
    for (std::size_t n = chunk.begin; n < chunk.end; ++n) {
      const std::size_t first = pattern_.row_begin(n);
      for (std::size_t b = pattern_.diagonal(n); b < pattern_.row_end(n); ++b) {
        position[static_cast<std::size_t>(pattern_.column(b))] = static_cast<std::uint32_t>(b - first);
      }
      for (PointIncidence& use : incidences_of(n)) {
        const motion::SkinnedPoint& point = model_.points[use.point];
        for (std::size_t k = 0; k < use.blocks.size(); ++k) {
          // Others are the transposes of some that are summed up there.
          const bool wanted = k < counts[use.point] && point.nodes[k] >= static_cast<int>(n);
          use.blocks[k] = wanted ? position[static_cast<std::size_t>(point.nodes[k])] : PointIncidence::kNone;
        }
      }
    }
  });
  edge_incidences_.resize(nodes);
  for (std::size_t e = 0; e < model_.edges.size(); ++e) {
    const GraphEdge& edge = model_.edges[e];
    edge_incidences_[static_cast<std::size_t>(edge.a)].push_back(
        {static_cast<int>(e), static_cast<std::uint32_t>(pattern_.find(edge.a, edge.b))});
    edge_incidences_[static_cast<std::size_t>(edge.b)].push_back(
        {static_cast<int>(e), static_cast<std::uint32_t>(pattern_.find(edge.b, edge.a))});
  }
}

double DeformingProblem::energy(const motion::LayerPose& pose) const {
  const TextureImage texture = texture_image(view_, level_);
  std::vector<double> parts(chunk_count(model_.points.size(), kPointsPerChunk));
  parallel_for(model_.points.size(), kPointsPerChunk, [&](const Chunk& chunk) {
    parts[chunk.index] = data_energy(part_of(pose.points, chunk), part_of(terms_, chunk), texture, weights_.huber);
  });
  return std::accumulate(parts.begin(), parts.end(), 0.0) + targets_energy(pose.nodes) +
         arap_energy(edges_, pose.rows, weights_.rigidity_sigma, weights_.huber);
}

double DeformingProblem::targets_energy(const motion::NodeStates& states) const {
  return target_energy(prior_, states) + target_energy(binding_, states);
}

double DeformingProblem::target_energy(std::span<const NodeTarget> targets, const motion::NodeStates& states) const {
  const Huber huber{weights_.huber};
  double sum = 0;
  for (std::size_t i = 0; i < targets.size(); ++i) {
    sum += huber.cost(targets[i].scale * (states.positions[i] - targets[i].position).norm());
  }
  return sum;
}

void DeformingProblem::set_prior(const motion::NodeStates& prior) {
  prior_.clear();
  for (const Eigen::Vector3d& position : prior.positions) prior_.push_back({position, 1 / weights_.prior_sigma});
}

// Renews the points' derivatives; returns their energy.
double DeformingProblem::jacobians_at(const motion::LayerPose& pose) {
  if (!jacobians_) jacobians_ = std::make_unique_for_overwrite<PointJacobians[]>(model_.points.size());
  const std::span<PointJacobians> jacobians(jacobians_.get(), model_.points.size());
  const TextureImage texture = texture_image(view_, level_);
  std::vector<double> parts(chunk_count(model_.points.size(), kPointsPerChunk));
  parallel_for(model_.points.size(), kPointsPerChunk, [&](const Chunk& chunk) {
    parts[chunk.index] = evaluate_jacobians(part_of(model_.points, chunk), pose.rows, part_of(pose.points, chunk),
                                            part_of(terms_, chunk), texture, weights_.huber,
                                            jacobians.subspan(chunk.begin, chunk.end - chunk.begin));
  });
  return std::accumulate(parts.begin(), parts.end(), 0.0);
}

const BlockSystem& DeformingProblem::linearise(const motion::LayerPose& pose, double& energy) {
  const motion::NodeStates& states = pose.nodes;
  if (point_incidences_begin_.empty()) find_pattern();
  arap_residuals_.resize(edges_.size());
  energy = jacobians_at(pose) + targets_energy(states) +
           arap_energy(edges_, pose.rows, weights_.rigidity_sigma, weights_.huber, arap_residuals_);
  system_.blocks.resize(pattern_.block_count());
  system_.gradient.assign(model_.nodes.size(), Twist::Zero());
  parallel_for(model_.nodes.size(), kNodesPerChunk, [&](const Chunk& chunk) {
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      add_points(i);
      add_arap_term(i, states);
      if (!prior_.empty()) add_target(i, prior_[i], states);
      if (!binding_.empty()) add_target(i, binding_[i], states);
    }
  });
  symmetrise(pattern_, system_);
  return system_;
}

// In single precision: a node has few hundred points.
void DeformingProblem::add_points(std::size_t node) {
  const std::size_t first = pattern_.row_begin(node);
  const std::size_t count = pattern_.row_end(node) - first;
  const std::span<Block> row = std::span(system_.blocks).subspan(first, count);
  std::fill(row.begin(), row.end(), Block());
  PointJacobians::Row gradient{};
  add_jacobian_products(incidences_of(node), {jacobians_.get(), model_.points.size()}, row, gradient);
  system_.gradient[node] += Eigen::Map<const Eigen::Matrix<float, 6, 1>>(gradient.data()).cast<double>();
}

// An edge (i, j) has two residuals: T_i x_j − c_j, with derivatives (1, −[T_i x_j − c_i]×) by i and −1 by j; and the
// same the other way round.
void DeformingProblem::add_arap_term(std::size_t node, const motion::NodeStates& states) {
  Block::Matrix diagonal_block = system_.blocks[pattern_.diagonal(node)].matrix();
  for (const EdgeIncidence& use : edge_incidences_[node]) {
    const auto e = static_cast<std::size_t>(use.edge);
    const int node_index = static_cast<int>(node);
    const bool is_first = edges_[e].a == node_index;
    const int other = is_first ? edges_[e].b : edges_[e].a;
    for (const bool outward : {true, false}) {
      const int from = outward ? node_index : other;
      const int to = outward ? other : node_index;
      const ArapResidual& found = arap_residuals_[e][is_first == outward ? 0 : 1];
      const float weight = found.weight;
      const Eigen::Vector3f lever = found.value + (states.positions[static_cast<std::size_t>(to)] -
                                                   states.positions[static_cast<std::size_t>(from)])
                                                      .cast<float>();
      const Eigen::Vector3f weighted_residual = weight * found.value;
      Eigen::Matrix3f lever_skew;
      lever_skew << 0, -lever.z(), lever.y(), lever.z(), 0, -lever.x(), -lever.y(), lever.x(), 0;
      lever_skew *= weight;
      diagonal_block.diagonal().head<3>().array() += weight;
      system_.gradient[node].head<3>() +=
          (outward ? weighted_residual : Eigen::Vector3f(-weighted_residual)).cast<double>();
      if (outward) {
        diagonal_block.topRightCorner<3, 3>() -= lever_skew;
        diagonal_block.bottomLeftCorner<3, 3>() += lever_skew;
        diagonal_block.bottomRightCorner<3, 3>() -= (weight * lever) * lever.transpose();
        diagonal_block.diagonal().tail<3>().array() += weight * lever.squaredNorm();
        system_.gradient[node].tail<3>() += lever.cross(weighted_residual).cast<double>();
      }
      if (other < node_index) continue;
      Block::Matrix between = system_.blocks[use.block].matrix();
      between.diagonal().head<3>().array() -= weight;
      if (outward) {
        between.bottomLeftCorner<3, 3>() -= lever_skew;
      } else {
        between.topRightCorner<3, 3>() += lever_skew;
      }
    }
  }
}

void DeformingProblem::add_target(std::size_t node, const NodeTarget& target, const motion::NodeStates& states) {
  const Eigen::Vector3d off = states.positions[node] - target.position;
  const double weight = Huber{weights_.huber}.weight(target.scale * off.norm()) * target.scale * target.scale;
  Block::Matrix diagonal_block = system_.blocks[pattern_.diagonal(node)].matrix();
  diagonal_block.diagonal().head<3>().array() += static_cast<float>(weight);
  system_.gradient[node].head<3>() += weight * off;
}

void DeformingProblem::linearise_rigid(const motion::LayerPose& pose, const Eigen::Vector3d& pivot,
                                       Matrix6d& information, Twist& gradient) const {
  struct Part {
    Matrix6d information = Matrix6d::Zero();
    Twist gradient = Twist::Zero();
  };
  const TextureImage texture = texture_image(view_, level_);
  std::vector<Part> parts(chunk_count(model_.points.size(), kPointsPerChunk));
  parallel_for(model_.points.size(), kPointsPerChunk, [&](const Chunk& chunk) {
    std::array<ResidualRows, kPointsPerChunk> rows;
    const std::span<ResidualRows> found(rows.data(), chunk.end - chunk.begin);
    evaluate_rows(part_of(pose.points, chunk), part_of(terms_, chunk), texture, weights_.huber, found);
    for (std::size_t i = 0; i < found.size(); ++i) {
      const Eigen::Vector3d lever = pose.points[chunk.begin + i].position.cast<double>() - pivot;
      for (const ResidualRow& row : found[i]) {
        if (row.gradient.isZero(0)) continue;
        const Eigen::Vector3d direction = row.gradient.cast<double>();
        Twist twist;
        twist << direction, lever.cross(direction);
        parts[chunk.index].information.noalias() += twist * twist.transpose();
        parts[chunk.index].gradient += static_cast<double>(row.residual) * twist;
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
