// Whether what is followed as a rigid object bends: then its surface keeps lying before its model in one place and
// behind it in another, however the model is moved as a whole. A hand before it is before it alone; and noise, a pose
// that is a little wrong, or a shape that slides along itself leave no region off by more than the sensor's noise.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "tracking/rigid/residuals.h"

namespace kinora::tracking {

/// What one view has against a rigid model, once the model is where it explains the view best by least squares.
struct RigidityViolation {
  double share = 0; ///< of the surface that both show: the largest connected region in front, or that behind, whichever
                    ///< is smaller
  double metres = 0; ///< by which these two lie apart, in the mean
};

/// Surface is looked at in cells, 64 of them on the label: one is off if three quarters of its points are, to the same
/// side, by 3σ and 5 mm at least: a graph that bends errs by as much itself. Only points two pixels within the label
/// count, within 10 cm and 45° of the plane that is measured. Thread-safe.
RigidityViolation rigidity_violation(std::span<const ModelPoint> points, const LayerView& view,
                                     const SE3& model_to_camera);

/// That a thing bends.
struct NonRigidity {
  std::size_t first_frame = 0; ///< of those that tell
  double metres = 0;           ///< the most that any frame shows
};

/// Gathers what frames tell. A thing bends once five frames more tell so than have told otherwise since. Not
/// thread-safe.
class NonRigidityTest {
public:
  /// What a frame that shows the thing at a place that can be believed tells.
  void add(std::size_t frame, const RigidityViolation& alignment_cost);
  /// Nothing unless it bends.
  std::optional<NonRigidity> non_rigidity() const { return is_certain_ ? std::optional(non_rigidity_) : std::nullopt; }

private:
  NonRigidity non_rigidity_;
  int surplus_ = 0; ///< frames that tell so, less those that told otherwise since the first of them
  bool is_certain_ = false;
};

} // namespace kinora::tracking
