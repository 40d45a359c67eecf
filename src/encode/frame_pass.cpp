#include "encode/frame_pass.h"

#include <fmt/format.h>

#include "core/error.h"
#include "encode/held_out_frames.h"
#include "encode/scene_tracker.h"
#include "ingest/depth/depth_unit.h"

namespace kinora::encode {
namespace {

bool is_held_out(std::size_t frame, int holdout) {
  return holdout > 0 && (frame + 1) % static_cast<std::size_t>(holdout) == 0;
}

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

FramePass pass_over_frames(ingest::Capture& capture, const EncodeOptions& options, StageTimes& times,
                           Progress& progress) {
  const ingest::CaptureInfo& info = capture.info();
  const auto expected = static_cast<std::size_t>(
      HeldOutFrames{options.holdout}.kept_of(static_cast<int>(options.expected_frames(info.frame_count))));
  FramePass pass{{}, fields::PixelStore(options.settings.budget.max_stored_pixels, expected), {}, {}, 0};
  SceneTracker scene(info, tracking_settings(options), progress);
  ingest::StreamEstimates streams;
  progress.stage("reading and tracking", expected);
  for (std::size_t i = 0;; ++i) {
    progress.check();
    const auto frame = times.measure("read", [&] { return capture.next(); });
    if (!frame) break;
    if (i == 0) warn_of_unit(*frame, progress);
    const bool held_out = is_held_out(i, options.holdout_tracked);
    add_to_timeline(*frame, held_out, pass.clip);
    if (i == 0 || info.has_poses) pass.clip.camera_to_world.push_back(frame->camera.camera_to_world);
    const bool labelled = !info.has_masks || frame->has_labels();
    streams.add(*frame);
    scene.add(*frame, times);
    if (!labelled) {
      ++pass.unlabelled;
      progress.warn(fmt::format("frame {} has no mask, unlike others; it is not trained on", frame->index));
    } else if (!held_out) {
      times.measure("store pixels", [&] { pass.pixels.add(*frame, static_cast<int>(i)); });
    }
    progress.advance(i + 1, "");
  }
  pass.labels = std::move(scene).finish(times);
  pass.streams = streams.report();
  pass.clip.intrinsics = info.intrinsics;
  if (pass.clip.times.empty()) {
    throw Error(ErrorCode::kCorruptInput, "the capture has no usable frame in the range; look at the warnings above");
  }
  return pass;
}

} // namespace kinora::encode
