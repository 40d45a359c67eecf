#include "encode/capture_report.h"

#include <algorithm>

#include "encode/rounding.h"
#include "ingest/registration_json.h"

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
          {"frames_without_mask", pass.unlabelled},
          {"frames_per_second", info.frames_per_second},
          {"has_poses", info.has_poses && !prepared.camera->moves()},
          {"has_masks", info.has_masks},
          {"stored_pixels", pass.pixels.pixels().size()},
          {"skipped", skipped}};
}

Json camera_json(const PreparedCapture& prepared) {
  if (!prepared.camera->report.is_null()) return prepared.camera->report;
  if (!prepared.capture->info().has_poses) return {{"path", "still"}, {"why", "nobody looked whether it moves"}};
  return {{"path", "moving"}, {"why", "the capture brings one camera pose per frame"}};
}

Json streams_json(const ingest::StreamReport& streams, const ingest::FoundRegistration& registration) {
  Json gains = Json::array();
  for (const double gain : streams.gains) gains.push_back(round4(gain));
  return {{"exposure_gains", std::move(gains)},
          {"exposure_changes", streams.exposure_changes},
          {"depth_behind_color_s", streams.time_offset ? Json(round4(*streams.time_offset)) : Json(nullptr)},
          {"registration", registration_json(registration)}};
}

} // namespace kinora::encode
