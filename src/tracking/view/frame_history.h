// The last frames of a layer, for a look back.
#pragma once

#include <cstddef>
#include <deque>

#include "ingest/frame/frame.h"
#include "tracking/view/layer_view.h"

namespace kinora::tracking {

/// Keeps the crops of as many frames as fit into 200 MB: of a person in a picture of 640×480 pixels, about 200. Not
/// thread-safe.
class FrameHistory {
public:
  /// The next frame, or what `view` shows of it; an empty view is remembered as an empty frame.
  void add(const ingest::Frame& frame, const LayerView& view);

  /// Frames ever added.
  std::size_t count() const { return count_; }
  /// The first of those that are remembered.
  std::size_t begin() const { return count_ - frames_.size(); }
  /// For begin() ≤ number < count(): the crop with a camera of its own. What is measured is what is clean.
  ingest::Frame at(std::size_t number) const;

private:
  std::deque<ingest::Frame> frames_; ///< without depth; only clean_depth
  std::size_t count_ = 0;
  std::size_t bytes_ = 0;
};

} // namespace kinora::tracking
