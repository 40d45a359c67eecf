#include "tracking/influence_table.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "core/parallel.h"

namespace kinora::tracking {
namespace {

constexpr double kCellsPerRadius = 5; // of influence
constexpr double kMostCells = 128;    // along an axis

// Whether node a is nearer than node b to every point of a cube: their squared distances differ by what is linear.
bool is_nearer_everywhere(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& centre,
                          double side) {
  return (a - centre).squaredNorm() - (b - centre).squaredNorm() + side * (a - b).lpNorm<1>() < 0;
}

/// Nodes that are among the nearest of some point of a cube: all but those to which enough others are nearer
/// everywhere. One more than have a say: the first that has none has its part in the weights.
class CandidateSearch {
public:
  CandidateSearch(const DeformationGraph& graph, double side)
      : side_(side), half_diagonal_(0.5 * std::sqrt(3.0) * side),
        nearest_(graph.nodes(), graph.influence_radius() + half_diagonal_) {}

  void append(const Eigen::Vector3d& centre, std::vector<std::int32_t>& candidates) const {
    constexpr std::size_t kWeighed = Influence::kMost + 1;
    std::array<NearestPoints::Neighbour, InfluenceTable::kMostCandidates> found{};
    const std::size_t within_reach = nearest_.find(centre, found);
    for (std::size_t i = 0; i < within_reach; ++i) {
      const Eigen::Vector3d& node = nearest_.points()[static_cast<std::size_t>(found[i].index)];
      std::size_t nearer = 0;
      for (std::size_t k = 0; k < i && nearer < kWeighed; ++k) {
        const Eigen::Vector3d& other = nearest_.points()[static_cast<std::size_t>(found[k].index)];
        if (is_nearer_everywhere(other, node, centre, side_)) ++nearer;
      }
      if (nearer < kWeighed) candidates.push_back(found[i].index);
      if (i >= kWeighed && is_out_of_question(found[kWeighed - 1], found[i])) break;
    }
  }

private:
  // So are all that are still farther from the centre.
  bool is_out_of_question(const NearestPoints::Neighbour& last, const NearestPoints::Neighbour& node) const {
    return std::sqrt(node.squared_distance) > std::sqrt(last.squared_distance) + 2 * half_diagonal_;
  }

  double side_;
  double half_diagonal_;
  NearestPoints nearest_;
};

} // namespace

InfluenceTable::InfluenceTable(std::shared_ptr<const DeformationGraph> graph) : graph_(std::move(graph)) {
  Eigen::AlignedBox3d bounds;
  for (const Eigen::Vector3d& node : graph_->nodes()) bounds.extend(node);
  origin_ = bounds.center();
  const double radius = graph_->influence_radius();
  const double side = std::max(radius / kCellsPerRadius, (bounds.sizes().maxCoeff() + 2 * radius) / kMostCells);
  const Eigen::Vector3d low = bounds.min() - Eigen::Vector3d::Constant(radius);
  for (int a = 0; a < 3; ++a) {
    const auto i = static_cast<std::size_t>(a);
    cells_.low[i] = static_cast<float>(low[a] - origin_[a]);
    cells_.count[i] = static_cast<std::int32_t>((bounds.sizes()[a] + 2 * radius) / side) + 1;
  }
  cells_.per_metre = static_cast<float>(1 / side);
  cells_.squared_influence_radius = static_cast<float>(radius * radius);
  cells_.inverse_squared_weight_radius = static_cast<float>(1 / (graph_->weight_radius() * graph_->weight_radius()));
  for (const Eigen::Vector3d& node : graph_->nodes()) {
    for (int a = 0; a < 3; ++a) cells_.positions.push_back(static_cast<float>(node[a] - origin_[a]));
    cells_.positions.push_back(0);
  }
  find_candidates(low, side);
}

void InfluenceTable::find_candidates(const Eigen::Vector3d& low, double side) {
  const CandidateSearch search(*graph_, side);
  const auto columns = static_cast<std::size_t>(cells_.count[0]);
  const auto rows_of_slice = static_cast<std::size_t>(cells_.count[1]);
  const std::size_t rows = rows_of_slice * static_cast<std::size_t>(cells_.count[2]);
  struct Part {
    std::vector<std::int32_t> counts, candidates;
  };
  constexpr std::size_t kRows = 64;
  std::vector<Part> parts(chunk_count(rows, kRows));
  parallel_for(rows, kRows, [&](const Chunk& chunk) {
    Part& part = parts[chunk.index];
    for (std::size_t row = chunk.begin; row < chunk.end; ++row) {
      const std::size_t y = row % rows_of_slice;
      const std::size_t z = row / rows_of_slice;
      for (std::size_t x = 0; x < columns; ++x) {
        const Eigen::Array3d cell(static_cast<double>(x), static_cast<double>(y), static_cast<double>(z));
        const std::size_t before = part.candidates.size();
        search.append(low + side * (cell + 0.5).matrix(), part.candidates);
        part.counts.push_back(static_cast<std::int32_t>(part.candidates.size() - before));
      }
    }
  });
  cells_.begin.push_back(0);
  for (const Part& part : parts) {
    for (const std::int32_t count : part.counts) cells_.begin.push_back(cells_.begin.back() + count);
    cells_.candidates.insert(cells_.candidates.end(), part.candidates.begin(), part.candidates.end());
  }
  if (cells_.candidates.empty()) cells_.candidates.push_back(0);
}

} // namespace kinora::tracking
