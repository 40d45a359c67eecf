// Rays through the density bricks of a field, many at a time, vectorised with Highway.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "fields/rendering/density_bricks.h"

namespace kinora::fields {

/// Coordinates are those of the bricks' lattice.
struct MarchRay {
  std::array<float, 3> origin;    ///< where step 0 begins
  std::array<float, 3> direction; ///< one step
};

/// How a run ended.
enum class RunEnd : std::uint8_t {
  kGap,    ///< after some opacity the field is empty again; the ray goes on
  kOpaque, ///< hardly any light is left
  kLeft    ///< no brick is there
};

/// What a ray meets between one empty stretch and the next: a surface, in general.
struct MarchRun {
  float opacity = 0; ///< share of the light that it takes away
  float mean = 0;    ///< step at which it does, in the mean; meaningless without opacity
  float median = 0;  ///< step at which half of all light is gone; where less is taken away, the mean
  float sigma = 0;   ///< standard deviation of the steps at which light is taken away
  float end = 0;     ///< step at which the ray stands afterwards
  RunEnd reason = RunEnd::kLeft;
};

/// Transmittance at which a ray ends.
inline constexpr float kOpaque = 0.004F;
/// A run ends where a step takes away a smaller share than this, once the run has taken away more than kRunBegins.
inline constexpr float kRunEnds = 1e-3F;
inline constexpr float kRunBegins = 1e-2F;

/// Follows ray i from step begin[i] (a whole number) to the end of its next run; densities are sampled in the middle of
/// each step, `optical_length` is the length of a step in units of the field's density_length(). Buffers: n long.
/// `index`: which bricks there are, in place of the bricks' own index.
void march(const DensityBricks& bricks, const MarchRay* rays, const float* begin, std::size_t n, float optical_length,
           MarchRun* runs, const std::int32_t* index = nullptr);

} // namespace kinora::fields
