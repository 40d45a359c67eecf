// A surface as Gaussian splats, in the attributes that splat viewers read.
// Source: Kerbl, Kopanas, Leimkühler, Drettakis, "3D Gaussian Splatting for Real-Time Radiance Field Rendering", ACM
// TOG 42(4), 2023, and the files of its program.
#pragma once

#include <array>
#include <vector>

#include "kinora/plugin.h"

namespace kinora::formats {

inline constexpr std::array<const char*, 17> kSplatProperties = {
    "x",       "y",       "z",       "nx",      "ny",    "nz",    "f_dc_0", "f_dc_1", "f_dc_2",
    "opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2",  "rot_3"};

/// As it lies in the file, in the order of kSplatProperties.
struct Splat {
  float position[3];
  float normal[3];
  float color[3];    ///< of the spherical harmonic of degree 0: (sRGB − 0.5) / 0.2821
  float opacity;     ///< before the logistic function
  float scale[3];    ///< natural logarithm of the standard deviation in metres
  float rotation[4]; ///< w x y z; the third axis becomes the normal
};
static_assert(sizeof(Splat) == kSplatProperties.size() * sizeof(float));

/// A flat Gaussian at each vertex of a mesh without fault, as wide as its triangles' sides ask for so that neighbours
/// leave no gaps. In Kinora's own axes, which are those of such files too.
std::vector<Splat> splats_of(const KinoraMesh& mesh);

} // namespace kinora::formats
