// Where the nodes of a deforming layer are expected in a view: on from their velocity, unless the view shows that the
// layer as a whole, or a limb, has jumped, or that its texture is elsewhere.
#pragma once

#include <span>
#include <vector>

#include "tracking/deforming/block_matching.h"
#include "tracking/deforming/model_in_view.h"

namespace kinora::tracking {

/// Limbs whose nodes are not where the bones have them.
struct LimbInitialisationConfig {
  double distance = 0.03;      ///< metres between both places: nearer, either leads to the other
  double min_share_gain = 0.1; ///< share of the bones' surface that would face the camera in addition
  double weight_share = 0.5;   ///< of a point's weights on the bones: above, it is theirs
};

struct PosePredictionConfig {
  double velocity_weight = 0.8; ///< of the last motion that the next one is expected to repeat
  double jump = 0.05;           ///< metres beyond what is expected: from less, alignment finds back
  double min_share_gain = 0.1;  ///< share of the surface that would face the camera in addition
  LimbInitialisationConfig limbs;
  BlockMatchingConfig flow;
};

/// The last view in which the layer was found.
struct TrackedView {
  LayerView view;
  SE3 origin_to_camera;
};

/// Transforms of the nodes are canonical to world, both relative to the origin. `last`: as they were in the last frame;
/// `expected`: by their velocity; `binding`: of the view's frame, whose number is `frame`.
std::vector<SE3> corrected_prediction(const ModelInView& now, const TrackedView& before, std::span<const SE3> last,
                                      const LayerBinding& binding, std::size_t frame, std::vector<SE3> expected,
                                      const PosePredictionConfig& config = {});

} // namespace kinora::tracking
