#include "encode/held_out_frames.h"

#include <utility>

namespace kinora::encode {
namespace {

class SomeFrames final : public ingest::Capture {
public:
  SomeFrames(std::unique_ptr<ingest::Capture> capture, std::function<bool(int)> wanted)
      : capture_(std::move(capture)), wanted_(std::move(wanted)) {}

  const ingest::CaptureInfo& info() const override { return capture_->info(); }
  const std::vector<ingest::SkippedFrame>& skipped() const override { return capture_->skipped(); }

  std::optional<ingest::Frame> next() override {
    std::optional<ingest::Frame> frame = capture_->next();
    while (frame && !wanted_(frame->index)) frame = capture_->next();
    return frame;
  }

private:
  std::unique_ptr<ingest::Capture> capture_;
  std::function<bool(int)> wanted_;
};

} // namespace

std::unique_ptr<ingest::Capture> frames_where(std::unique_ptr<ingest::Capture> capture,
                                              std::function<bool(int index)> wanted) {
  return std::make_unique<SomeFrames>(std::move(capture), std::move(wanted));
}

} // namespace kinora::encode
