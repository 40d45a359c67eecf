#include "tracking/deforming/canonical_model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/sensor_noise.h"
#include "core/statistics.h"
#include "motion/skinning/skinned_lanes.h"
#include "tracking/deforming/canonical_map.h"
#include "tracking/view/deforming_view.h"

namespace kinora::tracking {
namespace {

constexpr double kMinSpacing = 0.02;
constexpr double kMaxSpacing = 0.25;

TsdfConfig choose_volume(const LayerView& view, double requested) {
  const double footprint = view.centroid.z() / view.intrinsics.fx;
  const double sigma = kSensorNoise.sigma(view.centroid.z());
  TsdfConfig config;
  config.voxel_size = requested > 0 ? requested : std::clamp(std::max(1.2 * footprint, sigma), 0.002, 0.04);
  config.truncation = std::clamp(4 * sigma, 4 * config.voxel_size, 7 * config.voxel_size);
  return config;
}

std::size_t nearest_of(std::span<const Eigen::Vector3d> nodes, const Eigen::Vector3d& position) {
  const auto nearest =
      std::min_element(nodes.begin(), nodes.end(), [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
        return (a - position).squaredNorm() < (b - position).squaredNorm();
      });
  return static_cast<std::size_t>(nearest - nodes.begin());
}

} // namespace

CanonicalModel::CanonicalModel(const CanonicalModelConfig& config, TsdfVolume volume)
    : config_(config), volume_(std::move(volume)), components_(config.pieces) {}

std::optional<CanonicalModel> CanonicalModel::from_view(const LayerView& view, const SE3& camera_to_world,
                                                        const CanonicalModelConfig& config) {
  CanonicalModel model(config, TsdfVolume(choose_volume(view, config.voxel_size), camera_to_world * view.centroid));
  model.volume_.integrate(view.planes, view.texture, view.intrinsics, camera_to_world);
  model.surface_.update_points(model.volume_, {}, 0);
  if (model.surface_.points().empty()) return std::nullopt;
  const double per_node = measured_area(view) / static_cast<double>(config.first_nodes);
  const double least = std::max(kMinSpacing, 3 * model.volume_.config().voxel_size);
  model.spacing_ = config.node_spacing > 0 ? config.node_spacing : std::clamp(std::sqrt(per_node), least, kMaxSpacing);
  std::vector<double> weights;
  for (const SurfacePoint& point : model.surface_.points()) weights.push_back(point.weight);
  model.unit_weight_ = static_cast<float>(median(weights));
  model.grow_graph(0, {});
  return model;
}

std::shared_ptr<const motion::DeformationGraph> CanonicalModel::graph_in_world() const {
  std::vector<Eigen::Vector3d> nodes;
  for (const Eigen::Vector3d& node : nodes_) nodes.emplace_back(origin() + node);
  return std::make_shared<const motion::DeformationGraph>(std::move(nodes), graph_->weight_radius(),
                                                          graph_->influence_radius());
}

SE3 CanonicalModel::origin_to_camera(const SE3& camera_to_world) const {
  const SE3 world_to_camera = camera_to_world.inverse();
  return world_to_camera * Eigen::Translation3d(origin());
}

motion::NodeStates CanonicalModel::states(const SE3& origin_to_camera, std::span<const SE3> transforms) const {
  motion::NodeStates states;
  for (std::size_t n = 0; n < transforms.size(); ++n) {
    states.push_back(SE3(origin_to_camera * transforms[n]), nodes_[n]);
  }
  return states;
}

// Pieces apart from the model: each is carried back as if it had always moved with the node nearest to it. Returns that
// node for each new one.
std::vector<std::size_t> CanonicalModel::add_components(const LayerView& view, motion::NodeStates& states,
                                                        TsdfVolume::CanonicalMap& positions) {
  std::vector<std::size_t> anchor_nodes;
  for (const NewComponent& component : components_.add(view, positions)) {
    const std::size_t anchor = nearest_of(states.positions, component.centroid());
    const SE3 to_canonical = states.transforms[anchor].to_se3().inverse();
    std::vector<SurfaceSample> samples;
    for (std::size_t i = 0; i < component.cells.size(); ++i) {
      const Eigen::Vector3d position = to_canonical * component.points[i];
      if (graph_->influence(position).count > 0) continue; // something else is there in canonical space
      std::copy_n(position.cast<float>().eval().data(), 3,
                  positions.of_cell.pixel(component.cells[i][0], component.cells[i][1]));
      samples.push_back({position, Eigen::Vector3d::UnitZ()});
    }
    add_nodes(samples, spacing_, config_.max_nodes, nodes_);
    for (std::size_t n = states.size(); n < nodes_.size(); ++n) {
      states.push_back(DualQuaternion(states.transforms[anchor]), nodes_[n]);
      anchor_nodes.push_back(anchor);
    }
  }
  if (!anchor_nodes.empty()) update_graph();
  return anchor_nodes;
}

GraphGrowth CanonicalModel::fuse(const LayerView& view, motion::NodeStates states, std::size_t frame) {
  TsdfVolume::CanonicalMap positions =
      find_canonical_map(view, surface_.points(), surface_.skin(), states, config_.growth.max_surface_distance);
  GraphGrowth growth;
  growth.attached = add_components(view, states, positions);
  influences_.update(volume_, graph_);
  const std::vector<motion::TransformRow> transforms = motion::transform_rows(states.transforms);
  const auto to_camera = [&](std::size_t brick, const BrickCorners& points, BrickCorners& in_camera) {
    motion::InfluenceLanes influences;
    for (std::size_t i = 0; i < points.points.size(); ++i) {
      influences_.skinning_weights_of(brick, points.points[i], influences);
      motion::skin_points(transforms, influences, points.points[i], in_camera.points[i]);
    }
  };
  const std::vector<std::uint8_t> changed = volume_.integrate_non_rigid(
      view.planes, view.texture, view.intrinsics, to_camera, positions,
      surface_.skipped(frame, static_cast<std::size_t>(std::max(1, config_.fuse_interval))));
  surface_.update_points(volume_, changed, unit_weight_);
  if (!growth.attached.empty()) connect_graph(nodes_.size() - growth.attached.size(), 0);
  update_skinning();
  growth.grown = grow_graph(config_.growth.min_views * unit_weight_, changed);
  return growth;
}

void CanonicalModel::update_graph() {
  graph_ = std::make_shared<motion::DeformationGraph>(nodes_, config_.growth.weight_radius * spacing_,
                                                      config_.growth.influence_radius * spacing_);
}

// The graph and its edges, when there are more nodes than the `old` ones.
void CanonicalModel::connect_graph(std::size_t old, float min_weight) {
  update_graph();
  const double reach = 2 * EdgeConfig().reach * spacing_ + volume_.brick_size(); // more than is needed
  const auto about_new_nodes = [&](std::size_t brick) {
    const Eigen::Vector3d centre = volume_.brick_centre(brick);
    return std::any_of(nodes_.begin() + static_cast<std::ptrdiff_t>(old), nodes_.end(),
                       [&](const Eigen::Vector3d& node) { return (node - centre).squaredNorm() < reach * reach; });
  };
  const double cell = config_.growth.sample_spacing * spacing_;
  edges_.extend(nodes_, downsample_surface(surface_.points_of(about_new_nodes), cell, min_weight), spacing_, cell);
}

// The thinned surface of bricks that have changed (or have no mark), as far as it may lie beyond all nodes: whole cells
// of the thinning, which reach into bricks beside those that hold such points.
std::vector<SurfaceSample> CanonicalModel::unsupported_samples(float min_weight,
                                                               std::span<const std::uint8_t> changed) const {
  const double cell = config_.growth.sample_spacing * spacing_;
  const double beside = volume_.brick_size() + cell;
  std::vector<Eigen::Vector3d> beyond;
  const std::vector<std::uint8_t> marks = surface_.unsupported_bricks(nodes_, spacing_, min_weight, changed);
  for (std::size_t b = 0; b < marks.size(); ++b) {
    if (marks[b] != 0) beyond.push_back(volume_.brick_centre(b));
  }
  const auto is_beside = [&](std::size_t brick) {
    if (brick < changed.size() && changed[brick] == 0) return false;
    const Eigen::Vector3d centre = volume_.brick_centre(brick);
    return std::any_of(beyond.begin(), beyond.end(), [&](const Eigen::Vector3d& other) {
      return (other - centre).lpNorm<Eigen::Infinity>() < beside;
    });
  };
  if (beyond.empty()) return {};
  return downsample_surface(surface_.points_of(is_beside), cell, min_weight);
}

// What moves a place: the node nearest to it if none is near enough.
motion::Influence CanonicalModel::influence_at(const Eigen::Vector3d& position) const {
  motion::Influence influence = graph_->influence(position);
  if (influence.count > 0) return influence;
  influence.count = 1;
  influence.nodes[0] = static_cast<int>(nearest_of(nodes_, position));
  influence.weights[0] = 1;
  return influence;
}

// New nodes on surface that has none, in bricks that have changed (or have no mark). Returns what moved each of them
// before; nothing for the first nodes of all.
std::vector<motion::Influence> CanonicalModel::grow_graph(float min_weight, std::span<const std::uint8_t> changed) {
  const std::vector<SurfaceSample> samples = unsupported_samples(min_weight, changed);
  const std::size_t old = nodes_.size();
  std::vector<Eigen::Vector3d> nodes = nodes_;
  add_nodes(samples, spacing_, config_.max_nodes, nodes);
  if (nodes.size() == old) return {};
  std::vector<motion::Influence> movers;
  for (std::size_t n = old; n < nodes.size() && graph_; ++n) movers.push_back(influence_at(nodes[n]));
  nodes_ = std::move(nodes);
  connect_graph(old, min_weight);
  update_skinning();
  return movers;
}

void CanonicalModel::update_skinning() {
  influences_.update(volume_, graph_);
  surface_.update_skinning(influences_);
}

void CanonicalModel::set_canonical_pose(std::span<const SE3> pose) {
  const std::vector<Eigen::Vector3d> old_nodes = nodes_;
  for (std::size_t n = 0; n < nodes_.size(); ++n) nodes_[n] = pose[n] * old_nodes[n];
  warp_volume(old_nodes, pose);
  edges_ = {};
  connect_graph(0, 0);
  update_skinning();
}

void CanonicalModel::warp_volume(std::span<const Eigen::Vector3d> old_nodes, std::span<const SE3> pose) {
  std::vector<SurfacePoint> surface(surface_.points().begin(), surface_.points().end());
  for (std::size_t i = 0; i < surface.size(); ++i) {
    const motion::Influence& influence = surface_.skin()[i];
    if (influence.count == 0) continue;
    const SE3& anchor = pose[static_cast<std::size_t>(influence.nodes[0])];
    surface[i].position = (anchor * surface[i].position.cast<double>()).cast<float>();
  }
  const TsdfVolume old_volume = std::exchange(volume_, TsdfVolume(volume_.config(), volume_.origin()));
  const std::shared_ptr<const motion::DeformationGraph> old_graph = graph_;
  volume_.make_bricks(surface);
  update_graph();
  influences_ = {};
  influences_.update(volume_, graph_);
  // What lay where a place comes from was another piece's if it does not come back to it.
  motion::NodeStates there;
  motion::NodeStates back;
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    there.push_back(pose[n], old_nodes[n]);
    back.push_back(SE3(pose[n].inverse()), nodes_[n]);
  }
  const std::vector<motion::TransformRow> transforms_there = motion::transform_rows(there.transforms);
  const std::vector<motion::TransformRow> transforms_back = motion::transform_rows(back.transforms);
  const auto band = static_cast<float>(old_volume.config().truncation);
  volume_.resample(old_volume, [&](std::size_t brick, const motion::PointLanes& points, motion::PointLanes& positions) {
    motion::InfluenceLanes influences;
    influences_.skinning_weights_of(brick, points, influences);
    motion::skin_points(transforms_back, influences, points, positions);
    for (std::size_t i = 0; i < motion::PointLanes::kPoints; ++i) {
      const Eigen::Vector3f position = positions.at(i);
      influences.set(i, position.allFinite() ? old_graph->influence(position.cast<double>()) : motion::Influence());
    }
    motion::PointLanes again{};
    motion::skin_points(transforms_there, influences, positions, again);
    for (std::size_t i = 0; i < motion::PointLanes::kPoints; ++i) {
      const bool stays = (again.at(i) - points.at(i)).norm() <= band;
      if (!stays) positions.set(i, Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN()));
    }
  });
  surface_ = {};
  surface_.update_points(volume_, {}, unit_weight_);
}

} // namespace kinora::tracking
