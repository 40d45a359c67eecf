// What of a clip stands in which track of its file, and what cannot be stored.
#pragma once

#include <optional>
#include <string>

#include "clip/clip.h"
#include "clip/clip_description.h"
#include "clip/payloads/deformation_codec.h"

namespace kinora::clip {

/// Throws Error(kFailure): a clip cannot be stored, and why.
[[noreturn]] void refuse_to_store(const std::string& why);

/// Throws Error(kFailure) if the clip contradicts itself: sizes, times that do not increase, two layers of one name.
void check_storable(const Clip& clip);

/// Tracks are numbered from 1 on: the camera's, then those of each layer. Throws Error(kFailure) as above.
ClipDescription describe(const Clip& clip);

Bytes encode_camera(const SE3& camera_to_world);

/// Motion of one layer that is not still, as payloads: one for each frame, in their order. The motion must outlive it.
class MotionEncoder {
public:
  explicit MotionEncoder(const motion::Motion& motion);
  DeformationEncoder::Coded encode(std::size_t frame);

private:
  const motion::Motion& motion_;
  std::optional<DeformationEncoder> deformation_;
};

} // namespace kinora::clip
