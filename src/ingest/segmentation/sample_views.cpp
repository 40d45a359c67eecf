#include "ingest/segmentation/sample_views.h"

namespace kinora::ingest {
namespace {

constexpr int kSamples = 48;

} // namespace

std::vector<ReducedView> sample_views(const CaptureFactory& open, FrameRange range, Progress& progress) {
  std::unique_ptr<Capture> capture = open(range);
  const int frames = range.count_of(capture->info().frame_count);
  if (const int stride = (frames + kSamples - 1) / kSamples; stride > 1) {
    range.step *= stride;
    capture = open(range);
  }
  progress.stage("looking for what moves", static_cast<std::size_t>(std::min(frames, kSamples)));
  std::vector<ReducedView> samples;
  while (const auto frame = capture->next()) {
    samples.push_back(reduced_view(*frame, reduction_factor(frame->depth.width())));
    progress.advance(samples.size(), "");
  }
  return samples;
}

} // namespace kinora::ingest
