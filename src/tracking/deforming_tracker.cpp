#include "tracking/deforming_tracker.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>

#include "core/error.h"
#include "core/parallel.h"
#include "ingest/sensor_noise.h"
#include "tracking/deforming_selection.h"
#include "tracking/layer_search.h"
#include "tracking/layer_view.h"
#include "tracking/node_flow.h"
#include "tracking/residuals.h"
#include "tracking/statistics.h"

namespace kinora::tracking {
namespace {

constexpr double kMinSpacing = 0.02;
constexpr double kMaxSpacing = 0.25;

TsdfConfig choose_volume(const ObjectView& view, double requested) {
  const double footprint = view.centroid.z() / view.intrinsics.fx;
  const double sigma = ingest::depth_sigma(view.centroid.z());
  TsdfConfig config;
  config.voxel_size = requested > 0 ? requested : std::clamp(std::max(1.2 * footprint, sigma), 0.002, 0.04);
  config.truncation = std::clamp(4 * sigma, 4 * config.voxel_size, 7 * config.voxel_size);
  return config;
}

} // namespace

/// The last view that was tracked.
struct DeformingTracker::Past {
  ObjectView view;
  SE3 world_to_camera = SE3::Identity(); ///< world relative to the origin
  double time = 0;
  double earlier_time = 0;
  bool has_earlier = false; ///< the frame before it was tracked as well
};

DeformingTracker::DeformingTracker(int label, const DeformingTrackerConfig& config)
    : label_(label), config_(config), body_(config.body), interaction_(config.interaction) {}
DeformingTracker::~DeformingTracker() = default;
DeformingTracker::DeformingTracker(DeformingTracker&&) noexcept = default;
DeformingTracker& DeformingTracker::operator=(DeformingTracker&&) noexcept = default;

DeformingTrackingResult DeformingTracker::track(const ingest::Frame& frame, std::span<const NearbyObject> objects) {
  if (!config_.use_objects) objects = {};
  seen_.clear();
  ObjectView view = view_layer(frame, label_);
  DeformingTrackingResult result;
  result.pixels = view.depth_pixels;
  if (config_.use_body) body_.track(view, frame.camera.camera_to_world, frame.time, objects);
  if (volume_ == nullptr) {
    if (view.depth_pixels >= config_.first_pixels && begin(frame, view)) {
      result.health = Health::kTracked;
    } else {
      records_.emplace_back();
    }
  } else {
    records_.push_back({records_.back().nodes, Health::kHeld});
    if (view.depth_pixels >= config_.min_pixels) records_.back().health = follow(frame, view, objects, result);
    if (records_.back().health == Health::kTracked) {
      unseen_ = 0;
    } else if (++unseen_ > config_.held_frames) {
      records_.back().health = Health::kLost;
    }
    result.health = records_.back().health;
  }
  memory_.add(frame, view);
  if (result.health == Health::kTracked) past_->view = std::move(view);
  result.nodes = nodes_.size();
  return result;
}

// False if nothing of what is measured can be fused: it is nearer than any sensor measures.
bool DeformingTracker::begin(const ingest::Frame& frame, const ObjectView& view) {
  const Eigen::Vector3d origin = frame.camera.camera_to_world * view.centroid;
  volume_ = std::make_unique<TsdfVolume>(choose_volume(view, config_.voxel_size), origin);
  volume_->integrate(view.planes, view.texture, view.intrinsics, frame.camera.camera_to_world);
  surface_.renew_points(*volume_, {}, 0);
  if (surface_.points().empty()) {
    surface_ = {};
    volume_.reset();
    return false;
  }
  const double per_node = measured_area(view) / static_cast<double>(config_.first_nodes);
  spacing_ =
      config_.node_spacing > 0
          ? config_.node_spacing
          : std::clamp(std::sqrt(per_node), std::max(kMinSpacing, 3 * volume_->config().voxel_size), kMaxSpacing);
  records_.push_back({{}, Health::kTracked});
  std::vector<double> weights;
  for (const SurfacePoint& point : surface_.points()) weights.push_back(point.weight);
  unit_weight_ = weights.empty() ? 0 : static_cast<float>(median(weights));
  grow_graph(0, {});
  renew_skin();
  past_ = std::make_unique<Past>();
  past_->world_to_camera = relative_to_origin(frame);
  past_->time = frame.time;
  library_.add(records_.size() - 1, past_->world_to_camera, records_.back().nodes);
  learn_holds({}, {});
  return true;
}

// To be called after the last frame's alignment; the nodes that it has brought were not `seen` in it as yet.
void DeformingTracker::learn_holds(std::vector<double> seen, std::span<const NearbyObject> objects) {
  seen.resize(nodes_.size(), 0);
  std::vector<Eigen::Vector3d> places;
  std::vector<SE3> nodes;
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    nodes.push_back(records_.back().nodes[n]);
    nodes.back().translation() = places.emplace_back(volume_->origin() + records_.back().nodes[n] * nodes_[n]);
  }
  if (config_.use_body) body_.learn(nodes, seen);
  interaction_.learn(objects, places, seen);
  for (const NearbyObject& object : objects) met_[object.label] = records_.size() - 1;
  seen_ = std::move(seen);
}

SE3 DeformingTracker::relative_to_origin(const ingest::Frame& frame) const {
  SE3 world_to_camera = frame.camera.camera_to_world.inverse();
  return world_to_camera * Eigen::Translation3d(volume_->origin());
}

NodeStates DeformingTracker::states_in(const SE3& world_to_camera, const std::vector<SE3>& nodes) const {
  NodeStates states;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    states.push_back(SE3(world_to_camera * nodes[i]), nodes_[i]);
  }
  return states;
}

// Constant velocity of each node.
std::vector<SE3> DeformingTracker::predicted(double time) const {
  const std::vector<SE3>& last = records_[records_.size() - 2].nodes;
  if (unseen_ > 0 || !past_->has_earlier) return last;
  const std::vector<SE3>& earlier = records_[records_.size() - 3].nodes;
  const double before = past_->time - past_->earlier_time;
  const double share =
      config_.velocity_share * (before > 0 ? std::clamp((time - past_->time) / before, 0.0, 3.0) : 1.0);
  std::vector<SE3> result;
  for (std::size_t i = 0; i < last.size(); ++i) {
    const Eigen::Vector3d now = last[i] * nodes_[i];
    Twist rotation = Twist::Zero();
    rotation.tail<3>() = share * log_se3(last[i] * earlier[i].inverse()).tail<3>();
    SE3 next = SE3::Identity();
    next.linear() = exp_se3(rotation).linear() * last[i].linear();
    next.translation() = now + share * (now - earlier[i] * nodes_[i]) - next.linear() * nodes_[i];
    result.push_back(renormalized(next));
  }
  return result;
}

// Who jumps as a whole is where the middle of what is measured has gone.
void DeformingTracker::place_layer(const ObjectView& view, const SE3& world_to_camera, std::vector<SE3>& nodes) const {
  const std::vector<SE3>& last = records_[records_.size() - 2].nodes;
  Eigen::Vector3d step = Eigen::Vector3d::Zero();
  for (std::size_t n = 0; n < nodes.size(); ++n) step += nodes[n] * nodes_[n] - last[n] * nodes_[n];
  step /= static_cast<double>(nodes.size());
  const Eigen::Vector3d jump =
      world_to_camera.inverse() * view.centroid - past_->world_to_camera.inverse() * past_->view.centroid - step;
  if (jump.norm() < config_.search.jump) return;
  std::vector<SE3> moved = nodes;
  for (SE3& node : moved) node.translation() += jump;
  if (shown_share(view, states_in(world_to_camera, moved)) >
      shown_share(view, states_in(world_to_camera, nodes)) + config_.search.clearly_better) {
    nodes = std::move(moved);
  }
}

// Nodes whose texture is elsewhere than they are expected go there.
void DeformingTracker::follow_texture(const ObjectView& view, const SE3& world_to_camera, const NodeStates& then,
                                      std::vector<SE3>& nodes) const {
  const auto flow = find_node_flow(past_->view, then, view, states_in(world_to_camera, nodes), edges(), config_.flow);
  const Eigen::Matrix3d to_world = world_to_camera.linear().transpose();
  for (std::size_t n = 0; n < nodes.size(); ++n) nodes[n].translation() += to_world * flow[n];
}

// Where bones would have the nodes; or, of those that hold an object, where that would.
std::vector<NodePull> DeformingTracker::pulls(const SE3& from_world, std::span<const NearbyObject> objects) const {
  std::vector<NodePull> result = body_.pulls(records_.size() - 1, from_world);
  result.resize(nodes_.size());
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    const auto place = interaction_.place_of(n, objects);
    if (place) result[n] = {from_world * *place, 1 / config_.holding_sigma};
  }
  return result;
}

// The nodes as the bones would have them; none if there are no bones.
std::vector<SE3> DeformingTracker::placed_by_bones() const {
  std::vector<SE3> nodes = body_.placed(records_.size() - 1);
  if (nodes.size() != nodes_.size()) return {};
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    nodes[n].translation() -= volume_->origin() + nodes[n].linear() * nodes_[n];
    nodes[n] = renormalized(nodes[n]);
  }
  return nodes;
}

// Edges but those between surfaces that only happen to be side by side, by what the bones tell where they have a say.
std::vector<GraphEdge> DeformingTracker::holding_edges(std::span<const NodePull> binding) const {
  const auto is_pulled = [&](std::size_t node) { return node < binding.size() && binding[node].scale > 0; };
  std::vector<GraphEdge> holding;
  std::copy_if(edges().begin(), edges().end(), std::back_inserter(holding), [&](const GraphEdge& edge) {
    const auto a = static_cast<std::size_t>(edge.a);
    const auto b = static_cast<std::size_t>(edge.b);
    return !(is_pulled(a) && is_pulled(b) && body_.are_apart(a, b));
  });
  return holding;
}

bool DeformingTracker::is_healthy(const DeformingQuality& quality) const {
  return quality.inliers >= config_.min_pixels / 2 && quality.inlier_share() >= config_.min_inlier_share &&
         quality.empty_share() <= config_.max_empty_share;
}

// Without a frame just before, there is farther to go.
DeformingAlignment DeformingTracker::align_from_afar(const LayerModel& model, const DeformingSelection& selection,
                                                     const ObjectView& view, NodeStates start,
                                                     std::span<const NodePull> binding) const {
  DeformingAlignment alignment;
  alignment.nodes = std::move(start);
  for (int pass = 0; pass < config_.search.passes; ++pass) {
    alignment = align_deforming(model, selection.textures, view, alignment.nodes, alignment.nodes, spacing_,
                                config_.solver, binding);
  }
  return alignment;
}

// The share of the surface that would face the camera there that the view shows where it is.
double DeformingTracker::shown_share(const ObjectView& view, const NodeStates& states,
                                     const std::function<bool(const Influence&)>& takes_part) const {
  const DeformingSelection facing =
      select_facing(surface_.points(), surface_.skin(), view, states, config_.max_points, takes_part);
  if (facing.points.empty()) return 0;
  const DeformingQuality quality = judge_deformation({nodes_, edges(), facing.points}, facing.textures, view, states);
  return static_cast<double>(quality.inliers) / static_cast<double>(facing.points.size());
}

Health DeformingTracker::follow(const ingest::Frame& frame, const ObjectView& view,
                                std::span<const NearbyObject> objects, DeformingTrackingResult& result) {
  std::vector<SE3> expected = predicted(frame.time);
  const SE3 world_to_camera = relative_to_origin(frame);
  const NodeStates then = states_in(past_->world_to_camera, records_[records_.size() - 2].nodes);
  if (config_.use_searches) {
    place_layer(view, world_to_camera, expected);
    place_limbs(view, world_to_camera, expected);
    follow_texture(view, world_to_camera, then, expected);
  }
  const NodeStates prior = states_in(world_to_camera, expected);
  DeformingSelection selection = select_facing(surface_.points(), surface_.skin(), view, prior, config_.max_points);
  selection.add_last_view(past_->view, then);
  const std::vector<NodePull> binding = pulls(frame.camera.camera_to_world.inverse(), objects);
  const std::vector<GraphEdge> holding = holding_edges(binding);
  const LayerModel model{nodes_, holding, selection.points};
  DeformingAlignment alignment =
      align_deforming(model, selection.textures, view, prior, prior, spacing_, config_.solver, binding);
  result.quality = judge_deformation(model, selection.textures, view, alignment.nodes);
  const bool doubtful =
      result.quality.empty_share() > config_.search.max_free_space_share ||
      (result.quality.texture_correlation != 0 && result.quality.texture_correlation < config_.search.min_correlation);
  if (config_.use_searches && (unseen_ > 0 || doubtful || !is_healthy(result.quality))) {
    DeformingAlignment elsewhere =
        align_from_afar(model, selection, view, search_layer(model, selection.textures, view, prior).states, binding);
    const auto cost = [&](const NodeStates& states) { return contradiction(model, selection.textures, view, states); };
    if (cost(elsewhere.nodes) < cost(alignment.nodes)) alignment = std::move(elsewhere);
    if (const std::vector<SE3> placed = placed_by_bones(); !placed.empty()) {
      const NodeStates start = states_in(world_to_camera, placed);
      const DeformingSelection facing =
          select_facing(surface_.points(), surface_.skin(), view, start, config_.max_points);
      elsewhere = align_from_afar({nodes_, holding, facing.points}, facing, view, start, binding);
      if (shown_share(view, elsewhere.nodes) > shown_share(view, alignment.nodes)) alignment = std::move(elsewhere);
    }
    result.quality = judge_deformation(model, selection.textures, view, alignment.nodes);
    if (unseen_ > 0 || !is_healthy(result.quality)) {
      alignment = align_recalled(view, binding, std::move(alignment));
      const DeformingSelection facing =
          select_facing(surface_.points(), surface_.skin(), view, alignment.nodes, config_.max_points);
      result.quality = judge_deformation({nodes_, edges(), facing.points}, facing.textures, view, alignment.nodes);
    }
  }
  if (!is_healthy(result.quality)) return Health::kLost;
  const SE3 camera_to_world = world_to_camera.inverse();
  std::vector<SE3>& nodes = records_.back().nodes;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    nodes[i] = renormalized(camera_to_world * alignment.nodes.transforms[i].to_se3());
  }
  if (result.quality.empty_share() <= config_.search.max_free_space_share)
    library_.add(records_.size() - 1, world_to_camera, nodes);
  past_->has_earlier = unseen_ == 0;
  past_->earlier_time = past_->time;
  past_->time = frame.time;
  past_->world_to_camera = world_to_camera;
  if (const std::vector<std::size_t> parted = parted_nodes(alignment.seen); !parted.empty()) {
    take_pose_for_canonical(parted);
    alignment.nodes = states_in(world_to_camera, nodes);
  }
  fuse(view, alignment.nodes);
  learn_holds(std::move(alignment.seen), objects);
  return Health::kTracked;
}

Motion DeformingTracker::motion() const {
  if (!started()) throw Error(ErrorCode::kFailure, "a layer that was never seen has no motion");
  const Eigen::Vector3d& origin = volume_->origin();
  std::vector<Eigen::Vector3d> nodes;
  for (const Eigen::Vector3d& node : nodes_) nodes.emplace_back(origin + node);
  auto graph =
      std::make_shared<const DeformationGraph>(std::move(nodes), graph_->weight_radius(), graph_->influence_radius());
  const auto first = std::find_if(records_.begin(), records_.end(), [](const Record& r) { return !r.nodes.empty(); });
  std::vector<Motion::Deformation> deformations;
  for (const Record& record : records_) {
    Motion::Deformation deformation;
    deformation.health = record.health;
    for (const SE3& node : record.nodes.empty() ? first->nodes : record.nodes) {
      const SE3 in_world = Eigen::Translation3d(origin) * node * Eigen::Translation3d(-origin);
      deformation.node_to_world.push_back(DualQuaternion::from(in_world));
    }
    deformations.push_back(std::move(deformation));
  }
  return Motion::deforming(std::move(graph), std::move(deformations));
}

} // namespace kinora::tracking
