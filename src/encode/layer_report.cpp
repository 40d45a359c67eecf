#include "encode/layer_report.h"

#include <cmath>

namespace kinora::encode {

using Json = nlohmann::json;

double round4(double value) { return std::round(value * 1e4) / 1e4; }

Json config_json(const fields::FieldConfig& config) {
  const Eigen::Vector3d& origin = config.box.origin;
  return {{"box_origin_m", {origin.x(), origin.y(), origin.z()}},
          {"box_side_m", config.box.side},
          {"levels", config.levels},
          {"features_per_level", fields::FieldConfig::kFeatures},
          {"log2_table_size", config.log2_table_size},
          {"coarsest_resolution", config.coarsest_resolution},
          {"finest_resolution", config.finest_resolution},
          {"occupancy_resolution", config.occupancy_resolution},
          {"geometry", fields::name_of(config.geometry)}};
}

Json geometry_json(const fields::GeometryTrial& trial) {
  if (trial.frames == 0) return {{"chosen", fields::name_of(trial.chosen)}, {"why", "nothing else was tried"}};
  const auto error = [](const fields::DrawingError& e) {
    return Json{{"color_rms", round4(e.color)}, {"depth_median_m", round4(e.depth)}};
  };
  return {{"chosen", fields::name_of(trial.chosen)},
          {"why",
           "it drew frames that were not trained on with a smaller error of colour, or of depth where colour is alike"},
          {"rays", trial.rays},
          {"frames", trial.frames},
          {fields::name_of(fields::Geometry::kDensity), error(trial.density)},
          {fields::name_of(fields::Geometry::kSignedDistance), error(trial.signed_distance)}};
}

namespace {

Json body_json(const tracking::LayerBody& body) {
  using tracking::BodyVerdict;
  const auto why = [&] {
    switch (body.verdict()) {
    case BodyVerdict::kPerson:
      return "a skeleton lies on what is measured, and nowhere that the camera sees past: joints are stored";
    case BodyVerdict::kNobody:
      return "no skeleton explains it: it either leaves much unexplained, or would be where the camera sees past";
    case BodyVerdict::kUndecided:
      break;
    }
    return "too few frames show enough of it to tell whether it is a person";
  };
  return {{"verdict", tracking::name_of(body.verdict())},
          {"why", why()},
          {"explained", round4(body.explained())},
          {"empty", round4(body.empty())},
          {"detected_joints", round4(body.detected())}};
}

} // namespace

Json motion_json(const TrackedLabel& label, const tracking::Motion& motion) {
  Json out = {{"kind", tracking::name_of(motion.kind())}};
  if (label.bend) out["bends"] = {{"from_frame", label.bend->first_frame}, {"by_m", round4(label.bend->metres)}};
  if (motion.kind() == tracking::MotionKind::kStill && label.poses.empty()) return out;
  std::map<std::string, int> health{{"tracked", 0}, {"held", 0}, {"lost", 0}};
  const bool bends = motion.graph() != nullptr;
  for (const auto& deformation : motion.deformations()) ++health[std::string(tracking::name_of(deformation.health))];
  if (!bends) {
    for (const auto& pose : label.poses) ++health[std::string(tracking::name_of(pose.health))];
  }
  out["frames"] = health;
  if (bends) {
    out["nodes"] = motion.graph()->nodes().size();
    out["node_spacing_m"] = round4(label.bending->node_spacing());
    if (!label.bend) out["body"] = body_json(label.bending->body());
    return out;
  }
  out["relocalised"] = label.relocalised;
  out["weak_directions_per_frame"] = round4(label.weak_directions / static_cast<double>(label.poses.size()));
  out["largest_move_m"] = round4(SceneTracker::largest_move(label));
  return out;
}

Json refinement_json(const MotionRefinement& refinement, std::size_t draft_rays) {
  return {{"draft_rays", draft_rays},
          {"frames", refinement.frames},
          {"color_difference_before", round4(refinement.color_before)},
          {"color_difference_after", round4(refinement.color_after)}};
}

} // namespace kinora::encode
