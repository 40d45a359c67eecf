// How the canonical model of a deforming layer grows: measurements are fused, and surface without nodes gets some.
#include <algorithm>

#include "core/parallel.h"
#include "tracking/deforming_tracker.h"
#include "tracking/new_pieces.h"
#include "tracking/view_unfolding.h"

namespace kinora::tracking {
namespace {

// The node that is nearest to a place now.
std::size_t nearest_node(const NodeStates& states, const Eigen::Vector3d& place) {
  const auto nearest = std::min_element(states.positions.begin(), states.positions.end(),
                                        [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
                                          return (a - place).squaredNorm() < (b - place).squaredNorm();
                                        });
  return static_cast<std::size_t>(nearest - states.positions.begin());
}

} // namespace

// The pieces that have kept apart from the model for long enough. One that is apart for a moment is a part of the model
// that the tracker has lost and will find again.
std::vector<NewPiece> DeformingTracker::lasting_pieces(const ObjectView& view, const TsdfVolume::Places& places) {
  std::vector<NewPiece> lasting;
  std::vector<SeenPiece> seen;
  for (NewPiece& piece : find_new_pieces(view, places, config_.growth.piece_cells, config_.growth.piece_jump)) {
    const Eigen::Vector3d centroid = piece.centroid();
    int frames = 1;
    for (const SeenPiece& before : pieces_) {
      if ((before.centroid - centroid).norm() < config_.growth.piece_step) {
        frames = std::max(frames, before.frames + 1);
      }
    }
    seen.push_back({centroid, frames});
    if (frames >= config_.growth.piece_frames) lasting.push_back(std::move(piece));
  }
  pieces_ = std::move(seen);
  return lasting;
}

// Pieces apart from the model: each is carried back as if it had always moved with the node nearest to it.
void DeformingTracker::adopt_pieces(const ObjectView& view, NodeStates& states, TsdfVolume::Places& places) {
  const std::size_t old = nodes_.size();
  for (const NewPiece& piece : lasting_pieces(view, places)) {
    const std::size_t carrier = nearest_node(states, piece.centroid());
    const SE3 to_canonical = states.transforms[carrier].to_se3().inverse();
    std::vector<SurfaceSample> samples;
    for (std::size_t i = 0; i < piece.cells.size(); ++i) {
      const Eigen::Vector3d place = to_canonical * piece.points[i];
      if (graph_->influence(place).count > 0) continue; // something else is there in canonical space
      std::copy_n(place.cast<float>().eval().data(), 3, places.of_cell.pixel(piece.cells[i][0], piece.cells[i][1]));
      samples.push_back({place, Eigen::Vector3d::UnitZ()});
    }
    const std::size_t before = nodes_.size();
    add_nodes(samples, spacing_, config_.max_nodes, nodes_);
    for (std::size_t i = before; i < nodes_.size(); ++i) {
      states.push_back(DualQuaternion(states.transforms[carrier]), nodes_[i]);
      for (Record& record : records_) {
        if (!record.nodes.empty()) record.nodes.push_back(SE3(record.nodes[carrier]));
      }
    }
  }
  if (nodes_.size() == old) return;
  births_.resize(nodes_.size(), records_.size() - 1);
  graph_ = std::make_shared<DeformationGraph>(nodes_, config_.growth.weight_radius * spacing_,
                                              config_.growth.influence_radius * spacing_);
}

void DeformingTracker::fuse(const ObjectView& view, NodeStates states) {
  TsdfVolume::Places places =
      unfold_view(view, surface_.points(), surface_.skin(), states, config_.growth.unfold_reach);
  const std::size_t old = nodes_.size();
  adopt_pieces(view, states, places);
  influences_.renew(*volume_, graph_);
  const std::vector<float> transforms = packed_transforms(states);
  const auto to_camera = [&](std::size_t brick, const BrickCorners& points, BrickCorners& in_camera) {
    InfluenceLanes influences;
    for (std::size_t i = 0; i < points.points.size(); ++i) {
      influences_.weigh(brick, points.points[i], influences);
      carry_points(transforms, influences, points.points[i], in_camera.points[i]);
    }
  };
  const std::vector<std::uint8_t> changed = volume_->integrate_bent(
      view.planes, view.texture, view.intrinsics, to_camera, places,
      surface_.resting(records_.size(), static_cast<std::size_t>(std::max(1, config_.fuse_interval))));
  surface_.renew_points(*volume_, changed, unit_weight_);
  if (nodes_.size() > old) connect_graph(old, 0);
  renew_skin();
  grow_graph(config_.growth.min_views * unit_weight_, changed);
}

// To be called when there are more nodes than the `old` ones.
void DeformingTracker::connect_graph(std::size_t old, float min_weight) {
  graph_ = std::make_shared<DeformationGraph>(nodes_, config_.growth.weight_radius * spacing_,
                                              config_.growth.influence_radius * spacing_);
  const double reach = 2 * EdgeConfig().reach * spacing_ + volume_->brick_size(); // more than is needed
  const auto about_new_nodes = [&](std::size_t brick) {
    const Eigen::Vector3d centre = volume_->brick_centre(brick);
    return std::any_of(nodes_.begin() + static_cast<std::ptrdiff_t>(old), nodes_.end(),
                       [&](const Eigen::Vector3d& node) { return (node - centre).squaredNorm() < reach * reach; });
  };
  const double cell = config_.growth.sample_spacing * spacing_;
  edges_.extend(nodes_, thin_surface(surface_.points_of(about_new_nodes), cell, min_weight), spacing_, cell);
}

// The thinned surface of bricks that have changed (or have no mark), as far as it may lie beyond all nodes: whole cells
// of the thinning, which reach into bricks beside those that hold such points.
std::vector<SurfaceSample> DeformingTracker::samples_beyond_nodes(float min_weight,
                                                                  std::span<const std::uint8_t> changed) const {
  const double cell = config_.growth.sample_spacing * spacing_;
  const double beside = volume_->brick_size() + cell;
  std::vector<Eigen::Vector3d> beyond;
  const std::vector<std::uint8_t> marks = surface_.beyond_nodes(nodes_, spacing_, min_weight, changed);
  for (std::size_t b = 0; b < marks.size(); ++b) {
    if (marks[b] != 0) beyond.push_back(volume_->brick_centre(b));
  }
  const auto is_beside = [&](std::size_t brick) {
    if (brick < changed.size() && changed[brick] == 0) return false;
    const Eigen::Vector3d centre = volume_->brick_centre(brick);
    return std::any_of(beyond.begin(), beyond.end(), [&](const Eigen::Vector3d& other) {
      return (other - centre).lpNorm<Eigen::Infinity>() < beside;
    });
  };
  if (beyond.empty()) return {};
  return thin_surface(surface_.points_of(is_beside), cell, min_weight);
}

// New nodes on surface that has none, in bricks that have changed (or have no mark), with the past that the graph so
// far would have given them.
void DeformingTracker::grow_graph(float min_weight, std::span<const std::uint8_t> changed) {
  const std::vector<SurfaceSample> samples = samples_beyond_nodes(min_weight, changed);
  const std::size_t old = nodes_.size();
  std::vector<Eigen::Vector3d> nodes = nodes_;
  add_nodes(samples, spacing_, config_.max_nodes, nodes);
  for (std::size_t i = old; i < nodes.size(); ++i) {
    Influence influence = graph_ ? graph_->influence(nodes[i]) : Influence();
    if (graph_ && influence.count == 0) {
      const auto nearest = std::min_element(nodes_.begin(), nodes_.begin() + static_cast<std::ptrdiff_t>(old),
                                            [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
                                              return (a - nodes[i]).squaredNorm() < (b - nodes[i]).squaredNorm();
                                            });
      influence.count = 1;
      influence.nodes[0] = static_cast<int>(nearest - nodes_.begin());
      influence.weights[0] = 1;
    }
    for (Record& record : records_) {
      if (graph_ && record.nodes.empty()) continue;
      if (!graph_) {
        if (&record == &records_.back()) record.nodes.push_back(SE3::Identity());
        continue;
      }
      std::array<DualQuaternion, Influence::kMost> transforms;
      const auto count = static_cast<std::size_t>(influence.count);
      for (std::size_t k = 0; k < count; ++k) {
        transforms[k] = DualQuaternion::from(record.nodes[static_cast<std::size_t>(influence.nodes[k])]);
      }
      record.nodes.push_back(
          blend(std::span(transforms).first(count), std::span(influence.weights).first(count)).to_se3());
    }
  }
  if (nodes.size() > old) {
    nodes_ = std::move(nodes);
    births_.resize(nodes_.size(), records_.size() - 1);
    connect_graph(old, min_weight);
    renew_skin();
  }
}

void DeformingTracker::renew_skin() {
  influences_.renew(*volume_, graph_);
  surface_.renew_skin(influences_);
}

} // namespace kinora::tracking
