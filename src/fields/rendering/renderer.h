// Layers seen from any camera, all in one pass, in correct order of depth. A pixel's ray enters a layer where the hull
// of its density bricks, carried by the motion, is rasterised (proxy_mesh.h); from there it runs straight through
// canonical space until the bricks' densities make it opaque (ray_marching.h); the field itself is evaluated only at
// the surfaces that are found.
#pragma once

#include <memory>
#include <optional>
#include <span>

#include "core/camera.h"
#include "core/image.h"
#include "fields/model/confidence.h"
#include "fields/model/field.h"
#include "fields/rendering/proxy_mesh.h"
#include "motion/node_births.h"
#include "motion/warp.h"

namespace kinora::fields {

/// A field ready to be drawn: its parameters and what is derived from them. Immutable; copies share it; may be used by
/// several threads.
class DrawableField {
public:
  /// A field that somebody else holds must outlive this. `graph`: what moves the layer, if it deforms. `confidence`: of
  /// this field; without it nothing counts as seen. `detail`: with kHalf it is ready several times sooner, and surfaces
  /// lie less exactly.
  explicit DrawableField(std::shared_ptr<const Field> field, const motion::DeformationGraph* graph = nullptr,
                         std::optional<Confidence> confidence = std::nullopt, BrickDetail detail = BrickDetail::kWhole);
  explicit DrawableField(Field field, const motion::DeformationGraph* graph = nullptr,
                         std::optional<Confidence> confidence = std::nullopt, BrickDetail detail = BrickDetail::kWhole);
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
  std::shared_ptr<const PosedProxyMesh> proxy_mesh = nullptr; ///< of a layer that deforms; its own place is then in it
  /// World points back to canonical ones near the camera, where it stands inside of a deforming layer.
  std::shared_ptr<const motion::Warp> warp = nullptr;
  /// Numbers of bricks as DensityBricks::index, where some are not there yet; else null.
  std::shared_ptr<const std::vector<std::int32_t>> brick_index = nullptr;
};

/// Prepares a field to be drawn; for a deforming warp this carries the hull once for all cameras, and the field must
/// have been made with the warp's graph. Nothing is drawn of bricks that hang on nodes that are `unborn`.
PosedField pose(const DrawableField& field, const motion::Warp& warp, const motion::UnbornNodes& unborn = {});

struct Picture {
  ColorImage color; ///< 4 channels: sRGB and straight alpha (the opacity of what was drawn)
  DepthImage depth; ///< metres along the optical axis where alpha > 0.5, else 0
  LabelImage front; ///< 1 + index into `layers` of the one that contributes most at the pixel; 0 = nothing
  /// 3 channels: unit vector out of what is seen, in the camera's frame (x right, y down, z forward; so z < 0, but for
  /// rims), where alpha > 0.5, else 0. Empty unless asked for.
  Image<float> normal = {};
  /// How well the surface that is seen was seen by the capture's cameras (confidence.h): 255 is best, 0 never or
  /// nothing there. Mean over what contributes to the pixel, where alpha > 0.5. Empty unless asked for.
  Image<std::uint8_t> confidence = {};
};

/// What a picture costs and how close it comes to the field.
enum class DrawQuality {
  kFull,
  kFast ///< half as many samples along each side of the picture: where there is one for each pixel, one for each four
};

/// What becomes of surfaces whose shown side no camera of the capture ever saw.
enum class Unseen {
  kKeep, ///< drawn with the colours nearest to them
  kFade  ///< left out; layers of which it is not known stay
};

/// What is drawn beside colour and depth costs only those who ask for it.
struct DrawOptions {
  DrawQuality quality = DrawQuality::kFull;
  bool normals = false;
  bool confidence = false;
  Unseen unseen = Unseen::kKeep;
  static constexpr int kMaxSamples = 8;
  /// Along each side of a pixel: 1, 2, 4 or 8, fewer where the picture would have more than 16384 of them on a side.
  /// Colours are averaged by their opacity, in sRGB; depth is that of the sample in the middle of all from near to
  /// far, so that it is never averaged across an edge; `front` is the same sample's.
  int samples = 1;

  bool operator==(const DrawOptions&) const = default;
};

/// What some of the layers look like alone, drawn by the same camera with the same options.
struct Backdrop {
  const Picture* picture; ///< must outlive its use
  /// Indices of its layers among all that are drawn, ascending; they are posed as they were there.
  std::vector<std::uint8_t> layers;
};

/// Draws with all threads. Any camera is allowed: inside a layer, behind it, looking away. Same bits for any thread
/// count, and with a `backdrop`, from which pixels are taken that no other layer comes near. Throws Error(kUsage) for a
/// picture of no pixels or more than 16384 on a side.
Picture render(std::span<const PosedField> layers, const Camera& camera, const DrawOptions& options = {},
               const Backdrop* backdrop = nullptr);

} // namespace kinora::fields
