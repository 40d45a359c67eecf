// How points move, as a shape and a few others that are added to it with weights.
// Source: Alexa, Müller, "Representing Animations by Principal Components", Computer Graphics Forum 19(3), 2000.
#pragma once

#include <cstddef>
#include <vector>

#include "common/blended_mesh.h"

namespace kinora::formats {

inline constexpr std::size_t kMaxShapes = 64;

struct PrincipalShapes {
  std::vector<float> base;                ///< x y z of each point, metres
  std::vector<std::vector<float>> shapes; ///< x y z of each point: how far from the base it is at weight 1
  std::vector<float> weights;             ///< of all shapes for each pose, from 0 to 1: tools cut off the rest
  double error = 0;                       ///< root mean square distance from where the points are, metres
};

/// At most `most` shapes (1 to kMaxShapes), and no more than a tenth of a millimetre needs. Shapes are found from 64
/// poses spread over all, so memory does not grow with their number. Same bits every time.
PrincipalShapes principal_shapes(const BlendedMesh& mesh, std::size_t most);

} // namespace kinora::formats
