#include "ingest/segmentation/segmenter.h"

namespace kinora::ingest {
namespace {

class SegmentedCapture final : public Capture {
public:
  SegmentedCapture(std::unique_ptr<Capture> capture, std::unique_ptr<Segmenter> segmenter)
      : capture_(std::move(capture)), segmenter_(std::move(segmenter)), info_(capture_->info()) {
    info_.has_masks = true;
    info_.labels = segmenter_->labels();
  }

  const CaptureInfo& info() const override { return info_; }
  const std::vector<SkippedFrame>& skipped() const override { return capture_->skipped(); }

  std::optional<Frame> next() override {
    std::optional<Frame> frame = capture_->next();
    if (frame) segmenter_->label(*frame);
    return frame;
  }

private:
  std::unique_ptr<Capture> capture_;
  std::unique_ptr<Segmenter> segmenter_;
  CaptureInfo info_;
};

} // namespace

std::unique_ptr<Capture> segmented_capture(const CaptureFactory& open, const FrameRange& range,
                                           std::unique_ptr<Segmenter> segmenter, Progress& progress) {
  segmenter->prepare(open, range, progress);
  return std::make_unique<SegmentedCapture>(open(range), std::move(segmenter));
}

} // namespace kinora::ingest
