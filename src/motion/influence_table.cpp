#include "motion/influence_table.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "core/parallel.h"
#include "motion/skinning/node_candidates.h"

namespace kinora::motion {
namespace {

constexpr double kCellsPerRadius = 5; // of influence
constexpr double kMaxCells = 128;     // along an axis

} // namespace

InfluenceTable::InfluenceTable(std::shared_ptr<const DeformationGraph> graph) : graph_(std::move(graph)) {
  Eigen::AlignedBox3d bounds;
  for (const Eigen::Vector3d& node : graph_->nodes()) bounds.extend(node);
  origin_ = bounds.center();
  const double radius = graph_->influence_radius();
  const double side = std::max(radius / kCellsPerRadius, (bounds.sizes().maxCoeff() + 2 * radius) / kMaxCells);
  const Eigen::Vector3d low = bounds.min() - Eigen::Vector3d::Constant(radius);
  for (int a = 0; a < 3; ++a) {
    const auto i = static_cast<std::size_t>(a);
    cells_.low[i] = static_cast<float>(low[a] - origin_[a]);
    cells_.count[i] = static_cast<std::int32_t>((bounds.sizes()[a] + 2 * radius) / side) + 1;
  }
  cells_.per_metre = static_cast<float>(1 / side);
  cells_.squared_influence_radius = static_cast<float>(radius * radius);
  cells_.inverse_squared_weight_radius = static_cast<float>(1 / (graph_->weight_radius() * graph_->weight_radius()));
  cells_.positions = position_rows(graph_->nodes(), origin_);
  find_candidates(low, side);
}

void InfluenceTable::find_candidates(const Eigen::Vector3d& low, double side) {
  const NodeCandidates search(*graph_, side);
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

} // namespace kinora::motion
