// What a recording's file holds beside its pictures: the capture's description and a record of every frame.
// docs/container.md, section "A recording", specifies both.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "container/payload.h"
#include "kinora/plugin.h"

namespace kinora::recording {

inline constexpr const char* kRecordingKind = "recording";
inline constexpr const char* kDescriptionName = "recording.json";
inline constexpr const char* kFrameCodec = "S_KINORA/FRAME";
inline constexpr const char* kFfv1Codec = "V_FFV1";
inline constexpr const char* kMjpegCodec = "V_MJPEG";
inline constexpr std::uint16_t kFrameTrack = 0x5200; ///< pictures have the ids behind it

/// The pictures of a frame, in the order in which a file keeps them.
enum class Stream : std::uint8_t { kColor, kDepth, kInfrared, kConfidence, kLabels };
inline constexpr std::size_t kStreams = 5;

/// The name of a stream's track: "capture color", …
const char* track_name(Stream stream);

struct Label {
  int label = 0;
  std::string name;
  std::string kind;
};

/// Calibration and what else holds for all frames; as KinoraCaptureInfo says it.
struct Description {
  double start_time = 0;
  double frames_per_second = 30;
  KinoraCamera camera{};
  bool has_poses = false;
  bool has_masks = false;
  std::vector<Label> labels;
  std::optional<KinoraCamera> depth_camera;
  std::array<double, 16> depth_to_color{};
  std::string source_format; ///< of the capture that was recorded
};

Description description_of(const KinoraCaptureInfo& info, const std::string& source_format);

/// recording.json. Numbers come back as the same bits.
std::string to_json(const Description& description);
/// Throws Error(kCorruptInput), naming `source`.
Description description_from_json(std::string_view text, const std::string& source);

/// One picture of a frame: the block of its track with the time of the frame's record and these bytes.
struct Part {
  Stream stream = Stream::kColor;
  std::uint32_t checksum = 0; ///< CRC-32C of the block, which Matroska itself does not protect
};

/// What is known of one frame besides its pictures. It stands behind them: where it is, the frame is whole.
struct FrameRecord {
  std::int64_t index = 0;                   ///< in the capture that was recorded
  double time = 0;                          ///< the device's, seconds
  std::optional<std::int64_t> host_time_ns; ///< when the frame arrived, since 1970; live recordings alone
  double depth_unit = 0.001;
  std::optional<std::array<double, 16>> camera_to_world;
  std::uint32_t dropped_before = 0; ///< frames between the one before and this one that are not recorded
  std::vector<Part> parts;
  std::vector<std::uint32_t> sound; ///< CRC-32C of each packet of sound since the frame before
  std::string problem;              ///< why the source could not give the frame; then there are no parts
};

container::Bytes encode_record(const FrameRecord& record);
/// Throws Error(kCorruptInput), naming `location`.
FrameRecord decode_record(std::span<const std::byte> bytes, const std::string& location);

} // namespace kinora::recording
