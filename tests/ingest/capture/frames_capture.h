// A capture whose frames lie in memory.
#pragma once

#include <map>
#include <utility>
#include <vector>

#include "ingest/capture/capture.h"

namespace kinora::ingest::testing {

class FramesCapture final : public Capture {
public:
  /// At least one frame; they are numbered as they come. It has masks if one of them has.
  explicit FramesCapture(std::vector<Frame> frames, std::map<int, LabelInfo> labels = {}) : frames_(std::move(frames)) {
    info_.labels = std::move(labels);
    info_.frame_count = static_cast<int>(frames_.size());
    info_.intrinsics = frames_.front().camera.intrinsics;
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      frames_[i].index = static_cast<int>(i);
      frames_[i].time = static_cast<double>(i) / info_.frames_per_second;
      info_.has_masks |= frames_[i].has_labels();
    }
  }

  const CaptureInfo& info() const override { return info_; }
  const std::vector<SkippedFrame>& skipped() const override { return skipped_; }
  std::optional<Frame> next() override {
    return next_ < frames_.size() ? std::optional(frames_[next_++]) : std::nullopt;
  }

private:
  std::vector<Frame> frames_;
  std::size_t next_ = 0;
  CaptureInfo info_;
  std::vector<SkippedFrame> skipped_;
};

} // namespace kinora::ingest::testing
