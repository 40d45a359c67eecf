// Names by which a clip's file is known. docs/container.md specifies them.
#pragma once

#include <cstdint>
#include <string_view>

namespace kinora::clip {

inline constexpr std::string_view kClipKind = "clip";
inline constexpr std::string_view kLiveClipKind = "live clip";
inline constexpr std::string_view kFieldCodec = "S_KINORA/FIELD";
inline constexpr std::string_view kMotionCodec = "S_KINORA/MOTION";
inline constexpr std::string_view kConfidenceCodec = "S_KINORA/CONFIDENCE";
inline constexpr std::string_view kJointsCodec = "S_KINORA/JOINTS";
inline constexpr std::string_view kBirthsCodec = "S_KINORA/BIRTHS";
inline constexpr std::string_view kCameraCodec = "S_KINORA/CAMERA";
inline constexpr std::string_view kUpdateCodec = "S_KINORA/UPDATE"; ///< of a live clip, its only track

inline constexpr std::uint16_t kUpdateTrack = 1;

inline constexpr std::uint64_t kMaxPayloadBytes = std::uint64_t{24} << 20; ///< with its envelope

} // namespace kinora::clip
