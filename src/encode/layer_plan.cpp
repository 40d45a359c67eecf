#include "encode/layer_plan.h"

#include <fmt/format.h>

#include "core/error.h"

namespace kinora::encode {
namespace {

std::string default_name(int label) {
  switch (label) {
  case 0:
    return "background";
  case 1:
    return "person";
  case 2:
    return "object";
  default:
    return fmt::format("object{}", label - 1);
  }
}

std::string default_kind(int label) { return label == 0 ? "still" : label == 1 ? "deforming" : "rigid"; }

} // namespace

LayerPlan plan_layer(int label, const ingest::CaptureInfo& capture) {
  LayerPlan plan;
  plan.label = label;
  plan.name = default_name(label);
  std::string kind = default_kind(label);
  std::string source = label == 0 ? "what has no other label stays where it is in the world"
                                  : fmt::format("label {} is {} by default", label, kind);
  if (const auto found = capture.labels.find(label); found != capture.labels.end()) {
    if (!found->second.name.empty()) plan.name = found->second.name;
    if (!found->second.kind.empty()) {
      kind = found->second.kind;
      source = fmt::format("labels.json says that label {} is {}", label, kind);
      plan.is_specified = found->second.why.empty();
    }
    if (!found->second.why.empty()) {
      source = fmt::format("{} ({})", kind, found->second.why);
    }
  }
  if (kind == "still") {
    plan.motion = motion::MotionKind::kStill;
    plan.why = source + ": no motion is stored";
  } else if (kind == "rigid") {
    plan.motion = motion::MotionKind::kRigid;
    plan.why = source + ": one pose per frame is tracked";
  } else if (kind == "deforming") {
    plan.motion = motion::MotionKind::kDeforming;
    plan.why = source + ": the bending of a graph is tracked";
  } else {
    throw Error(ErrorCode::kCorruptInput, fmt::format("labels.json gives label {} the kind \"{}\"; use deforming, "
                                                      "rigid or still",
                                                      label, kind));
  }
  return plan;
}

} // namespace kinora::encode
