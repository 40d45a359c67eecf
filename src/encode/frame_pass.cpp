#include "encode/frame_pass.h"

#include "core/error.h"
#include "encode/front_end.h"
#include "encode/held_out_frames.h"

namespace kinora::encode {
namespace {

bool is_held_out(std::size_t frame, int holdout) {
  return holdout > 0 && (frame + 1) % static_cast<std::size_t>(holdout) == 0;
}

} // namespace

FramePass pass_over_frames(ingest::Capture& capture, const EncodeOptions& options, StageTimes& times,
                           Progress& progress) {
  const ingest::CaptureInfo& info = capture.info();
  const auto expected = static_cast<std::size_t>(
      HeldOutFrames{options.holdout}.kept_of(static_cast<int>(options.expected_frames(info.frame_count))));
  FramePass pass{{}, fields::PixelStore(options.settings.budget.max_stored_pixels, expected), {}, {}, 0};
  FrontEnd front_end(info, options, progress);
  progress.stage("reading and tracking", expected);
  for (std::size_t i = 0;; ++i) {
    progress.check();
    const auto frame = times.measure("read", [&] { return capture.next(); });
    if (!frame) break;
    const bool held_out = is_held_out(i, options.holdout_tracked);
    const bool labelled = front_end.add(*frame, held_out, times);
    if (labelled && !held_out) {
      times.measure("store pixels", [&] { pass.pixels.add(*frame, static_cast<int>(i)); });
    }
    progress.advance(i + 1, "");
  }
  pass.unlabelled = front_end.unlabelled();
  pass.depth_delay = front_end.depth_delay();
  pass.clip = front_end.timeline();
  pass.labels = std::move(front_end).finish(times);
  if (pass.clip.times.empty()) {
    throw Error(ErrorCode::kCorruptInput, "the capture has no usable frame in the range; look at the warnings above");
  }
  return pass;
}

} // namespace kinora::encode
