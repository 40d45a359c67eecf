// Parts of a deforming layer that come into view apart from all that is known of it: a second hand, say.
#pragma once

#include <array>
#include <vector>

#include "tracking/tsdf/tsdf.h"
#include "tracking/view/layer_view.h"

namespace kinora::tracking {

/// A piece of measured surface that hangs together and shows nothing known.
struct NewComponent {
  std::vector<std::array<int, 2>> cells; ///< column and row in `CanonicalMap`
  std::vector<Eigen::Vector3d> points;   ///< what the middle of each cell measures, in the camera
  Eigen::Vector3d centroid() const;
};

/// Pieces of at least `min_cells` cells, in the order of their first cell. Neighbouring cells hang together where
/// their depths differ by less than `max_jump` metres.
std::vector<NewComponent> find_new_components(const LayerView& view, const TsdfVolume::CanonicalMap& positions,
                                              std::size_t min_cells, double max_jump);

struct NewPieceConfig {
  int frames = 8;             ///< in a row that show a piece apart before it is taken in
  double max_step = 0.08;     ///< metres that a piece may go from frame to frame
  std::size_t min_cells = 12; ///< that a piece has
  double max_jump = 0.03;     ///< metres between depths of neighbouring cells
};

/// The pieces that have kept apart from what is known for long enough to be taken in. One that is apart for a moment is
/// a part that was lost and will be found again. Not thread-safe.
class PersistentComponents {
public:
  explicit PersistentComponents(const NewPieceConfig& config = {}) : config_(config) {}

  /// The next frame. Returns those of its pieces that frame after frame has shown, up to this one.
  std::vector<NewComponent> add(const LayerView& view, const TsdfVolume::CanonicalMap& positions);

private:
  struct Seen {
    Eigen::Vector3d centroid; ///< in the camera
    int frames;               ///< in a row that have shown it
  };
  NewPieceConfig config_;
  std::vector<Seen> seen_; ///< in the last frame
};

} // namespace kinora::tracking
