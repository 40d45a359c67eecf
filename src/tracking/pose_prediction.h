// Where the nodes of a deforming layer are expected in a view: on from their velocity, unless the view shows that the
// layer as a whole, or a limb, has jumped, or that its texture is elsewhere.
#pragma once

#include <span>
#include <vector>

#include "tracking/model_in_view.h"

namespace kinora::tracking {

/// The last view in which the layer was found.
struct FoundView {
  ObjectView view;
  SE3 origin_to_camera;
};

/// Transforms of the nodes are canonical to world, both relative to the origin. `last`: as they were in the last frame;
/// `expected`: by their velocity; `binding`: of the view's frame, whose number is `frame`.
std::vector<SE3> corrected_prediction(const ModelInView& now, const FoundView& before, std::span<const SE3> last,
                                      const LayerBinding& binding, std::size_t frame, std::vector<SE3> expected);

} // namespace kinora::tracking
