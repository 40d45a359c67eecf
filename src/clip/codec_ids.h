// Names by which a clip's file is known. docs/container.md specifies them.
#pragma once

#include <string_view>

namespace kinora::clip {

inline constexpr std::string_view kClipKind = "clip";
inline constexpr std::string_view kFieldCodec = "S_KINORA/FIELD";
inline constexpr std::string_view kMotionCodec = "S_KINORA/MOTION";
inline constexpr std::string_view kConfidenceCodec = "S_KINORA/CONFIDENCE";
inline constexpr std::string_view kJointsCodec = "S_KINORA/JOINTS";
inline constexpr std::string_view kCameraCodec = "S_KINORA/CAMERA";

} // namespace kinora::clip
