// The JSON attachments of a clip's file: clip.json (timeline, layers), calibration.json, metadata.json.
// docs/container.md specifies them.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "clip/coding/zstd_codec.h"
#include "core/camera.h"
#include "motion/motion.h"
#include "motion/presence.h"

namespace kinora::clip {

/// Attachment names.
inline constexpr const char* kClipFile = "clip.json";
inline constexpr const char* kCalibrationFile = "calibration.json";
inline constexpr const char* kMetadataFile = "metadata.json"; ///< of files made before it was compressed
inline constexpr const char* kCompressedMetadataFile = "metadata.json.zst";

struct LayerDescription {
  std::string name;
  int label = 0;
  motion::MotionKind kind = motion::MotionKind::kStill;
  std::uint16_t field_track = 0;
  std::uint16_t motion_track = 0;     ///< only if the layer moves
  std::uint16_t confidence_track = 0; ///< 0: the file does not say
  std::uint16_t joints_track = 0;     ///< 0: the layer has no skeleton
  std::uint16_t births_track = 0;     ///< 0: all of it is there from the start
  motion::Presence presence = {};     ///< within the clip's frames
};

struct ClipDescription {
  std::vector<std::int64_t> times_ns; ///< one per frame, increasing, not negative
  std::vector<int> capture_frames;
  std::vector<bool> held_out;
  std::uint16_t camera_track = 0;
  bool camera_moves = false;
  std::vector<LayerDescription> layers;
};

Bytes to_json(const ClipDescription& description);
Bytes to_json(const Intrinsics& intrinsics);
/// Invalid UTF-8 becomes the replacement character.
Bytes to_json(const nlohmann::json& metadata);

/// All three are safe for untrusted input and throw Error(kCorruptInput) naming `location`, or kNotRecognised if the
/// file was made by a newer Kinora.
ClipDescription parse_clip_description(std::span<const std::byte> text, const std::string& location);
Intrinsics parse_intrinsics(std::span<const std::byte> text, const std::string& location);
nlohmann::json parse_json(std::span<const std::byte> text, const std::string& location);

} // namespace kinora::clip
