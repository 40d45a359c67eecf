// The canonical mesh, carried by the motion and rasterised: each pixel gets the canonical place at which its ray enters
// the mesh, and from there the ray runs straight through a thin shell. It is how pictures are drawn
// (fields/renderer.h).
#pragma once

#include <optional>

#include "fields/canonical_search.h"
#include "fields/rendering/projected_layer.h"

namespace kinora::bench {

class ProxySurface : public CanonicalSearch {
public:
  /// The mesh is the hull of the field's density bricks, which follow the instants' graph. `corrected`: each sample is
  /// then moved to where the motion, interpolated in its cell of the hull, carries it to its place in the world.
  ProxySurface(const fields::DrawableField& field, bool corrected);

  void prepare(const Instant& instant) override;
  void find(const std::vector<SearchRay>& rays, Positions& positions) override;

private:
  const fields::DrawableField* field_;
  bool corrected_;
  Camera camera_;
  fields::PosedField posed_;
  std::optional<fields::ProjectedLayer> view_;
  std::optional<fields::TriangleBins> bins_;
  std::vector<fields::Entry> entries_; // of all pixels, nearest first
  std::vector<std::uint32_t> begin_;   // per pixel, into entries_; one more at the end
  fields::kernels::PointLanes points_, positions_;
};

} // namespace kinora::bench
