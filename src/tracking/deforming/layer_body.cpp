#include "tracking/deforming/layer_body.h"

#include <algorithm>

namespace kinora::tracking {

std::string_view name_of(BodyVerdict verdict) {
  switch (verdict) {
  case BodyVerdict::kPerson:
    return "person";
  case BodyVerdict::kNobody:
    return "nobody";
  case BodyVerdict::kUndecided:
    break;
  }
  return "undecided";
}

BodyVerdict LayerBody::verdict() const {
  if (frames_ < config_.deciding_frames) return BodyVerdict::kUndecided;
  const bool fits = explained() >= config_.min_explained && free_space() <= config_.max_free_space;
  return fits ? BodyVerdict::kPerson : BodyVerdict::kNobody;
}

void LayerBody::track(const LayerView& view, const SE3& camera_to_world, double time,
                      std::span<const NearbyObject> objects) {
  if (verdict() == BodyVerdict::kNobody) return;
  last_ = tracker_.track(view, camera_to_world, time, objects);
  records_.emplace_back();
  if (!tracker_.started()) return;
  const BodyState& state = tracker_.state();
  records_.back() = Record{forward_kinematics(state.pose, state.shape), last_.limbs,
                           last_.health == motion::Health::kTracked && !last_.refitted};
  if (last_.health == motion::Health::kHeld) return;
  ++frames_;
  explained_ += last_.explained;
  free_space_ += last_.free_space_share;
  detected_ += static_cast<double>(last_.detected);
}

std::vector<NodeTarget> LayerBody::targets(std::size_t frame, const SE3& from_world) const {
  if (verdict() != BodyVerdict::kPerson || frame >= records_.size()) return {};
  const std::optional<Record>& record = records_[frame];
  if (!record || !record->trusted) return {};
  return binding_.targets(record->bones, record->limbs, from_world, config_.binding_sigma);
}

std::vector<SE3> LayerBody::node_transforms(std::size_t frame) const {
  if (verdict() != BodyVerdict::kPerson || frame >= records_.size() || !records_[frame]) return {};
  return binding_.node_transforms(records_[frame]->bones);
}

bool LayerBody::is_visible(Limb limb) const {
  if (verdict() != BodyVerdict::kPerson || records_.empty() || !records_.back()) return false;
  return records_.back()->trusted && records_.back()->limbs[limb] == LimbHealth::kSeen;
}

std::optional<motion::JointPaths> LayerBody::joint_paths() const {
  const auto first =
      std::find_if(records_.begin(), records_.end(), [](const auto& record) { return record.has_value(); });
  if (verdict() != BodyVerdict::kPerson || first == records_.end()) return std::nullopt;
  motion::JointPaths paths;
  for (const JointInfo& joint : joints()) paths.names.emplace_back(joint.name);
  for (const std::optional<Record>& record : records_) {
    std::vector<Eigen::Vector3d>& positions = paths.positions.emplace_back();
    for (const SE3& bone : (record ? *record : **first).bones) positions.emplace_back(bone.translation());
  }
  return paths;
}

void LayerBody::update(std::span<const SE3> nodes, std::span<const double> seen) {
  if (verdict() == BodyVerdict::kNobody || last_.health != motion::Health::kTracked) return;
  const PosedBody body = pose_body(tracker_.state().pose, tracker_.state().shape);
  if (last_.refitted) binding_ = {};
  binding_.update_offsets(body.bones, nodes, seen);
  binding_.bind(body, nodes, seen);
}

} // namespace kinora::tracking
