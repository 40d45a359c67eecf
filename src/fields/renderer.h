// Layers seen from any camera, all in one pass, in correct order of depth.
#pragma once

#include <memory>
#include <span>

#include "core/camera.h"
#include "core/image.h"
#include "fields/field.h"
#include "fields/live_space.h"
#include "tracking/warp.h"

namespace kinora::fields {

/// A field ready to be drawn: its parameters and what is derived from them (a distance field over the occupancy).
/// Immutable; copies share it; may be used by several threads.
class DrawableField {
public:
  explicit DrawableField(Field field);
  const Field& field() const;
  struct Derived;
  const Derived& derived() const { return *derived_; }

private:
  std::shared_ptr<const Derived> derived_;
};

/// A field where its layer is at one instant.
struct PosedField {
  const DrawableField* field = nullptr; ///< must outlive this
  SE3 canonical_to_world = SE3::Identity();
  std::shared_ptr<const LiveSpace> live = nullptr; ///< of a layer that deforms; its own place is then in the warp
};

/// Prepares a field to be drawn; for a deforming warp this inverts the warp once for all rays.
PosedField pose(const DrawableField& field, const tracking::Warp& warp);

struct Picture {
  ColorImage color; ///< 4 channels: sRGB and straight alpha (the opacity of what was drawn)
  DepthImage depth; ///< metres along the optical axis where alpha > 0.5, else 0
  LabelImage front; ///< 1 + index into `layers` of the one that contributes most at the pixel; 0 = nothing
};

/// Draws with all threads. Any camera is allowed: inside a layer, behind it, looking away. Same bits for any thread
/// count. Throws Error(kUsage) for a picture of no pixels or more than 16384 on a side.
Picture render(std::span<const PosedField> layers, const Camera& camera);

} // namespace kinora::fields
