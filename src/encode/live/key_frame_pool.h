// The frames that live training looks at: some of all that was seen, chosen by a rule, and the newest.
#pragma once

#include <algorithm>
#include <cstddef>
#include <deque>
#include <map>
#include <memory>
#include <vector>

#include "encode/live/layer_looks.h"
#include "encode/live/live_snapshot.h"
#include "encode/live/paper_distance.h"
#include "encode/live_settings.h"

namespace kinora::encode {

struct KeyFrame {
  int number = 0; ///< on the timeline
  std::shared_ptr<const ingest::Frame> frame;
};

/// Not thread-safe. Same calls, same frames.
class KeyFramePool {
public:
  explicit KeyFramePool(const KeyFrameConfig& config) : config_(config) {
    config_.capacity = std::max<std::size_t>(config.capacity, 2);
  }

  /// Frames come in the order of their numbers. `snapshot`: must know where the layers are in this frame.
  void add(const KeyFrame& frame, const LiveSnapshot& snapshot);

  /// Ascending, the newest one with them.
  std::vector<KeyFrame> frames() const;
  /// The spatial-temporal pool for a camera that looks at the snapshot's last frame. Ascending.
  std::vector<KeyFrame> frames_for(const SE3& camera_to_world, const LiveSnapshot& snapshot) const;
  std::size_t blurred() const { return blurred_; } ///< frames that were left out

private:
  struct Kept {
    KeyFrame frame;
    std::map<int, std::vector<Look>> looks; ///< by label
    std::map<int, PaperView> views;         ///< by label
  };

  bool is_blurred(const ingest::Frame& frame);
  Kept described(const KeyFrame& frame, const LiveSnapshot& snapshot);
  void keep_at_intervals(Kept next);
  void keep_far_ones(Kept next);
  void keep_covering_ones(Kept next);
  double distance(const Kept& a, const Kept& b) const;
  std::vector<double> worths() const;

  KeyFrameConfig config_;
  std::vector<Kept> kept_;
  std::deque<KeyFrame> newest_;    ///< config.similar of them at most
  std::deque<double> sharpness_;   ///< of the last frames
  std::map<int, PlaceGrid> grids_; ///< by label
  std::size_t added_ = 0;
  std::size_t interval_ = 1;
  std::size_t blurred_ = 0;
};

} // namespace kinora::encode
