#include "encode/front_end.h"

#include <fmt/format.h>

#include "ingest/depth/depth_unit.h"

namespace kinora::encode {
namespace {

void add_to_timeline(const ingest::Frame& frame, bool held_out, clip::Clip& clip) {
  if (clip.times.empty()) clip.metadata["start_seconds"] = frame.time;
  clip.times.push_back(frame.time - clip.metadata["start_seconds"].get<double>());
  clip.capture_frames.push_back(frame.index);
  clip.held_out.push_back(held_out);
}

void warn_of_unit(const ingest::Frame& frame, Progress& progress) {
  if (const std::string doubt = ingest::depth_unit_warning(frame.depth); !doubt.empty()) progress.warn(doubt);
}

TrackingSettings tracking_settings(const EncodeOptions& options) {
  TrackingSettings settings = options.settings.tracking;
  if (options.body) settings.deforming.binding.body.tracker.known = *options.body;
  return settings;
}

} // namespace

FrontEnd::FrontEnd(const ingest::CaptureInfo& info, const EncodeOptions& options, Progress& progress)
    : info_(info), progress_(progress), scene_(info, tracking_settings(options), progress) {
  clip_.intrinsics = info.intrinsics;
}

bool FrontEnd::add(const ingest::Frame& frame, bool held_out, StageTimes& times) {
  const bool is_first = clip_.times.empty();
  if (is_first) warn_of_unit(frame, progress_);
  add_to_timeline(frame, held_out, clip_);
  if (is_first || info_.has_poses) clip_.camera_to_world.push_back(frame.camera.camera_to_world);
  delay_.add(frame);
  scene_.add(frame, times);
  if (!info_.has_masks || frame.has_labels()) return true;
  ++unlabelled_;
  progress_.warn(fmt::format("frame {} has no mask, unlike others; it is not trained on", frame.index));
  return false;
}

} // namespace kinora::encode
