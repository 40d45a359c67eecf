// A rigid pose as the bytes of a S_KINORA/MOTION or S_KINORA/CAMERA payload, and back. docs/container.md specifies
// them.
#pragma once

#include <span>
#include <string>

#include "clip/coding/zstd_codec.h"
#include "core/se3.h"
#include "motion/motion.h"

namespace kinora::clip {

/// 23 bytes: translation in micrometres, the three smallest components of the rotation's quaternion in units of 2⁻²³.
/// The error is at most half a micrometre for each axis and 5e-7 rad. Beyond 2 km, 40 bytes. Thread-safe. Throws
/// Error(kFailure) if the pose is not finite or farther than 10⁹ m from the origin.
Bytes encode_pose(const motion::Motion::Pose& pose);

/// encode_pose(decode_pose(b)) = b for every b that encode_pose wrote. Safe for untrusted input. Thread-safe.
/// Throws Error(kCorruptInput) naming `location`.
motion::Motion::Pose decode_pose(std::span<const std::byte> payload, const std::string& location);

} // namespace kinora::clip
