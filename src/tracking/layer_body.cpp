#include "tracking/layer_body.h"

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
  const bool fits = explained() >= config_.min_explained && empty() <= config_.max_empty;
  return fits ? BodyVerdict::kPerson : BodyVerdict::kNobody;
}

void LayerBody::track(const ObjectView& view, const SE3& camera_to_world, double time) {
  if (verdict() == BodyVerdict::kNobody) return;
  last_ = tracker_.track(view, camera_to_world, time);
  if (last_.health == Health::kHeld || !tracker_.started()) return;
  ++frames_;
  explained_ += last_.explained;
  empty_ += last_.empty;
}

std::vector<NodePull> LayerBody::pulls(const SE3& from_world) const {
  if (verdict() != BodyVerdict::kPerson || last_.health != Health::kTracked || last_.refitted) return {};
  const BodyState& state = tracker_.state();
  return binding_.pulls(place_bones(state.pose, state.shape), last_.limbs, from_world, config_.binding_sigma);
}

void LayerBody::learn(std::span<const Eigen::Vector3d> places, std::span<const double> seen) {
  if (verdict() == BodyVerdict::kNobody || last_.health != Health::kTracked) return;
  const PosedBody body = pose_body(tracker_.state().pose, tracker_.state().shape);
  if (last_.refitted) binding_ = {};
  binding_.renew(body.bones, places, seen);
  binding_.bind(body, places);
}

} // namespace kinora::tracking
