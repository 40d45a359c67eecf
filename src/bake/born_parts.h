// The parts of a layer's mesh by when they are there: what came into view late is not shown before.
#pragma once

#include <cstdint>
#include <vector>

#include "clip/clip.h"
#include "host/mesh_writer.h"

namespace kinora::bake {

/// A piece of a mesh, and the frame from which on it is there.
struct BornPart {
  std::uint32_t birth = 0;
  host::Mesh mesh;
};

/// The canonical mesh of a layer in at most `max_parts` pieces, the earliest first; a triangle is there when all its
/// corners are. Where there are more births than pieces, those between are put off to the next one's. One piece, which
/// is the mesh, if all of it is there from the same frame on. Names of the later ones end with their frame.
std::vector<BornPart> born_parts(host::Mesh mesh, const clip::Layer& layer, std::size_t max_parts);

} // namespace kinora::bake
