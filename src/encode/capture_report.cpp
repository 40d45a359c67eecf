#include "encode/capture_report.h"

#include <algorithm>
#include <numbers>

#include <fmt/format.h>

#include "encode/rounding.h"
#include "ingest/depth/registration_json.h"

namespace kinora::encode {
namespace {

using Json = nlohmann::json;

Json registration_json(const ingest::FoundRegistration& found) {
  if (found.pairs == 0) return {{"applied", false}, {"why", "needs a camera that moves, and views that show the same"}};
  return {{"applied", found.geometry.has_value()},
          {"pairs", found.pairs},
          {"unexplained_as_given", round4(found.unexplained_as_given)},
          {"unexplained", round4(found.unexplained)},
          {"cameras", found.geometry ? ingest::to_json(*found.geometry) : Json(nullptr)}};
}

Json followed_json(const CameraPath& camera) {
  const Json frames = {{"tracked", camera.tracked}, {"held", camera.held}, {"lost", camera.lost}};
  if (!camera.moving_from) {
    return {{"path", "still"},
            {"why", "no stretch of frames is explained significantly better by another place of the camera"},
            {"frames", frames}};
  }
  return {{"path", "moving"},
          {"why", *camera.moving_from == 0
                      ? "along it more of what the frames show keeps still than if the camera had not moved"
                      : fmt::format("from frame {} of the timeline on, the background is explained significantly "
                                    "better by another place of the camera",
                                    *camera.moving_from)},
          {"frames", frames},
          {"key_frames", camera.key_frames},
          {"loops", camera.loops}};
}

} // namespace

Json capture_json(const PreparedCapture& prepared, const FramePass& pass) {
  const ingest::Capture& capture = *prepared.capture;
  const ingest::CaptureInfo& info = capture.info();
  Json skipped = Json::array();
  for (const ingest::SkippedFrame& frame : capture.skipped()) {
    skipped.push_back({{"frame", frame.index}, {"reason", frame.reason}});
  }
  const auto held_out = std::count(pass.clip.held_out.begin(), pass.clip.held_out.end(), true);
  return {{"format", info.format},
          {"size", {info.intrinsics.width, info.intrinsics.height}},
          {"frames_in_source", info.frame_count},
          {"frames_used", pass.clip.times.size()},
          {"frames_held_out", held_out},
          {"held_out_frames_are", prepared.held_out ? "unseen"
                                  : held_out > 0    ? "tracked"
                                                    : "none"},
          {"frames_without_mask", pass.unlabelled},
          {"frames_per_second", info.frames_per_second},
          {"has_poses", info.has_poses && !prepared.camera->moves()},
          {"has_masks", info.has_masks},
          {"stored_pixels", pass.pixels.pixels().size()},
          {"skipped", skipped}};
}

Json clip_metadata(const ingest::CaptureInfo& info, const Json& config, const Json& settings) {
  Json metadata = {{"encoder", {{"version", KINORA_VERSION}, {"options", config}, {"settings", settings}}},
                   {"frames_per_second", info.frames_per_second}};
  if (info.registration) metadata["registration"] = ingest::to_json(*info.registration);
  return metadata;
}

Json camera_json(const PreparedCapture& prepared) {
  const CameraPath& camera = *prepared.camera;
  switch (camera.origin) {
  case CameraPath::Origin::kFollowed:
    return followed_json(camera);
  case CameraPath::Origin::kNothingBetter:
    return {{"path", "still"}, {"why", "no path that was found explains the pictures better"}};
  case CameraPath::Origin::kNotFollowed:
    break;
  }
  if (!prepared.capture->info().has_poses) return {{"path", "still"}, {"why", "nobody looked whether it moves"}};
  return {{"path", "moving"}, {"why", "the capture brings one camera pose per frame"}};
}

Json refinement_json(const CameraRefinement& refinement) {
  const bool rolls = refinement.readout.color != 0;
  return {{"draft_rays", refinement.draft.rays},
          {"frames", refinement.frames},
          {"color_difference_before", round4(refinement.color_before)},
          {"color_difference_after", round4(refinement.color_after)},
          {"moved_m", round4(refinement.metres)},
          {"turned_degrees", round4(refinement.radians * 180 / std::numbers::pi)},
          {"rolling_shutter_s", rolls ? Json(round4(refinement.readout.color)) : Json(nullptr)},
          {"depth_rolling_shutter_s", rolls ? Json(round4(refinement.readout.depth)) : Json(nullptr)}};
}

Json streams_json(const clip::Exposure& exposure, std::optional<double> depth_delay,
                  const ingest::FoundRegistration& registration) {
  Json gains = Json::array();
  for (const auto& [frame, gain] : exposure) {
    Json colors = Json::array();
    for (const float factor : gain.factors) colors.push_back(round4(factor));
    gains.push_back(std::move(colors));
  }
  return {{"exposure_changes", !exposure.empty()},
          {"exposure_gains", std::move(gains)},
          {"depth_behind_color_s", depth_delay ? Json(round4(*depth_delay)) : Json(nullptr)},
          {"registration", registration_json(registration)}};
}

} // namespace kinora::encode
