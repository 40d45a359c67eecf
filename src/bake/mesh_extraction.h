// A layer's field as a mesh with colours or a texture.
#pragma once

#include <optional>

#include "bake/surface_nets.h"
#include "clip/clip.h"
#include "core/progress.h"
#include "host/mesh_writer.h"

namespace kinora::bake {

struct MeshExtractionOptions {
  std::size_t triangles = 200'000; ///< so many per layer and a tenth at most; fewer if the field has no more detail
  int resolution = 0;              ///< cells per side of the layer's box; 0: as `triangles` asks
  double opacity = 0.2; ///< the surface is where a way of one cell of the field's finest level is this opaque: a ray
                        ///< that grazes it passes some three cells, of which half of the light is then stopped, so that
                        ///< silhouettes are those of pictures; in soft fields where less is, so that nine tenths of all
                        ///< opacity are inside
  double simplification =
      0; ///< metres by which the surface may be off, so that it has fewer triangles where it is flat
  double still_simplification = 0;      ///< the same for layers that do not move
  double flat_simplification = 0;       ///< the same for those that are flat as a whole besides, within 10 cm: floors
  int texture = 0;                      ///< pixels per side at most of a texture; 0: colours in the vertices instead
  double min_component_share = 0.02;    ///< parts with less than this share of the largest one's faces are left out
  double still_component_share = 0.005; ///< the same for layers that do not move, where things stand by themselves
};

/// The surface in canonical space, without a skin. Colours are what a ray from outside composites just behind the
/// surface, in the mean of what light it stands in during the clip. Nothing if the layer has no surface. Uses all
/// threads; same bits for any number of them. Throws Error: kUsage for options that make no sense, kInterrupted.
std::optional<host::Mesh> extract_mesh(const clip::Layer& layer, const MeshExtractionOptions& options,
                                       const Progress& progress);

} // namespace kinora::bake
