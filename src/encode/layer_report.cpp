#include "encode/layer_report.h"

#include "encode/rounding.h"
#include "encode/setting_list.h"
#include "encode/size_report.h"

namespace kinora::encode {
namespace {

using Json = nlohmann::json;

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
  return {{"verdict", name_of(body.verdict())},
          {"why", why()},
          {"explained", round4(body.explained())},
          {"empty", round4(body.free_space())},
          {"detected_joints", round4(body.detected())}};
}

Json motion_json(const TrackedLabel& label, const motion::Motion& motion) {
  Json out = {{"kind", motion::name_of(motion.kind())}};
  if (label.non_rigidity)
    out["bends"] = {{"from_frame", label.non_rigidity->first_frame}, {"by_m", round4(label.non_rigidity->metres)}};
  if (motion.kind() == motion::MotionKind::kStill && label.poses.empty()) return out;
  std::map<std::string, int> health{{"tracked", 0}, {"held", 0}, {"lost", 0}};
  const bool deforms = motion.graph() != nullptr;
  for (const auto& deformation : motion.deformations()) ++health[std::string(motion::name_of(deformation.health))];
  if (!deforms) {
    for (const auto& pose : label.poses) ++health[std::string(motion::name_of(pose.health))];
  }
  out["frames"] = health;
  if (deforms) {
    out["nodes"] = motion.graph()->nodes().size();
    out["node_spacing_m"] = round4(label.layer->node_spacing);
    if (!label.non_rigidity) out["body"] = body_json(label.layer->body);
    return out;
  }
  out["relocalised"] = label.relocalised;
  out["weak_directions_per_frame"] = round4(label.degenerate_directions / static_cast<double>(label.poses.size()));
  out["largest_move_m"] = round4(label.max_displacement());
  return out;
}

Json refinement_json(const DraftReport& draft) {
  return {{"draft_rays", draft.rays},
          {"frames", draft.refinement.frames},
          {"color_difference_before", round4(draft.refinement.color_before)},
          {"color_difference_after", round4(draft.refinement.color_after)}};
}

Json views_json(const fields::ViewConsistency& consistency) {
  return {{"looks", consistency.observations},
          {"seen_through", round4(consistency.free_space_violations)},
          {"noise", round4(consistency.noise)}};
}

Json length_json(const fields::ExchangeRate& rate, const fields::TrainingReport& training) {
  Json out = {{"why", fields::reason_of(training.length)}};
  if (training.looks.empty()) return out;
  for (const fields::TrainingLook& look : training.looks)
    out["psnr_held_apart"].push_back({{"rays", look.rays}, {"psnr", psnr(look.error)}});
  out["next"] = {{"rays", training.outlook.rays},
                 {"gain_db", round4(training.outlook.decibels)},
                 {"processor_s", round4(training.outlook.seconds)},
                 {"asked_db", round4(rate.decibels_per_second * training.outlook.seconds)}};
  return out;
}

Json training_json(const fields::ExchangeRate& rate, const fields::TrainingReport& training) {
  Json reasons = Json::array();
  for (const fields::Collapse collapse : training.restarts) reasons.push_back(name_of(collapse));
  return {{"rays", training.rays},
          {"samples", training.samples},
          {"steps", training.steps},
          {"bytes", training.bytes},
          {"final_loss", training.final_loss},
          {"restarts", training.restarts.size()},
          {"restarted_because", std::move(reasons)},
          {"stray_cells", training.carved_cells},
          {"length", length_json(rate, training)}};
}

} // namespace

Json layer_json(const TrackedLabel& tracked, const LayerOutcome& outcome) {
  const clip::Layer& layer = outcome.layer;
  Json out = {{"name", layer.name},
              {"label", layer.label},
              {"why", outcome.why},
              {"pixels_seen", tracked.pixels},
              {"views", views_json(outcome.consistency)},
              {"parameters", layer.field.parameter_count()},
              {"occupied_cells", layer.field.occupancy.count()},
              {"motion", motion_json(tracked, layer.motion)},
              {"field", config_json(layer.field.config)},
              {"size", size_json(outcome.requirements, outcome.config, layer.field, outcome.training)},
              {"geometry", geometry_json(outcome.geometry)},
              {"training", training_json(outcome.trainer.exchange, outcome.training)}};
  if (outcome.draft) out["refinement"] = refinement_json(*outcome.draft);
  const std::vector<std::uint32_t>& births = layer.births.frames();
  if (!births.empty())
    out["nodes_born_late"] = std::count_if(births.begin(), births.end(), [](std::uint32_t frame) { return frame > 0; });
  for (const motion::FrameSpan& span : layer.presence.away()) out["away"].push_back({span.begin, span.end});
  return out;
}

Json layer_metadata(const LayerOutcome& outcome) {
  return {{"label", outcome.layer.label},
          {"why", outcome.why},
          {"field", config_json(outcome.layer.field.config)},
          {"trainer", settings_json(outcome.trainer)}};
}

Json not_modelled_json(const std::vector<NotModelled>& labels) {
  Json out = Json::array();
  for (const NotModelled& label : labels) {
    out.push_back({{"name", label.name}, {"label", label.label}, {"why", label.why}});
  }
  return out;
}

} // namespace kinora::encode
