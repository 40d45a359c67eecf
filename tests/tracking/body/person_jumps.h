// A person who stands still, and between two frames is elsewhere: how far a tracker can be thrown and find back.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "motion/motion.h"
#include "tracking/body/person_camera.h"

namespace kinora::tracking::testing {

enum class Jump {
  kPersonShift,    ///< metres, level, in any direction
  kPersonRotation, ///< degrees about the vertical
  kHandShift,      ///< metres of the wrist, the arm bending as it must
  kForearmRotation ///< degrees about the elbow
};
constexpr std::array<Jump, 4> kEveryJump = {Jump::kPersonShift, Jump::kPersonRotation, Jump::kHandShift,
                                            Jump::kForearmRotation};
std::string_view name_of(Jump jump);

constexpr int kJumpFrame = 12;  ///< the first one after the jump; whether a layer is a person is known by then
constexpr int kJumpFrames = 17; ///< in all; still again from kJumpFrame on

/// `trial`: who it is, how arms are held, which way it goes (the sizes of a trial go the same way, from the same
/// pose). Its fast parts are those that jump. At most 0.3 metres and 40 degrees.
PersonScene jumping_person(Jump jump, double size, std::uint64_t trial);

/// Metres, in `frame`, of the points of those parts that are seen there and in the last frame before the jump, each
/// tracked from where it was then. `frames`: that the motion has.
std::vector<double> errors_after_jump(const PersonScene& scene, const motion::Motion& motion, std::size_t frames,
                                      int frame, const PersonCamera& camera, std::size_t points);

} // namespace kinora::tracking::testing
