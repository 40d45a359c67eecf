// Frames of a plugin's reader, converted and cleaned: the serial work behind a capture.
#pragma once

#include "host/frame_reader.h"
#include "ingest/capture/capture.h"
#include "ingest/depth/registration.h"
#include "ingest/depth/undistortion.h"

namespace kinora::ingest {

/// What became of one position of the capture.
struct SourceResult {
  int index = 0;
  std::size_t dropped = 0; ///< frames that a device lost before this one
  double device_time = 0;  ///< of the frame, as the plugin gives it
  std::optional<Frame> frame;
  std::string problem;        ///< why there is no frame; empty with a frame and at the end
  bool has_infrared = false;  ///< the plugin delivered an infrared image, which no part of Kinora uses
  bool mask_was_laid = false; ///< on edges: it missed them
  bool end = false;
};

/// Not thread-safe, but may be used from different threads one after another.
class FrameSource {
public:
  FrameSource(host::FrameReader reader, const CaptureOptions& options);

  const host::FrameReader& reader() const { return reader_; }
  const Intrinsics& intrinsics() const { return intrinsics_; }
  /// The next position within the range. Throws Error when reading cannot go on.
  SourceResult next();

private:
  Frame convert(const KinoraFrame& given) const;
  DepthImage depth_of(const KinoraFrame& given) const;
  void use_registration(const RegistrationGeometry& given);

  host::FrameReader reader_;
  FrameRange range_;
  bool use_masks_;
  bool masks_on_edges_;
  double max_depth_;
  DepthCleaning cleaning_;
  int position_;
  Intrinsics intrinsics_;
  std::optional<Undistortion> undistortion_;
  /// Of a depth camera that is not the colour camera, and where that is if poses are the depth camera's.
  std::optional<RegistrationGeometry> registration_;
  std::optional<Undistortion> depth_undistortion_;
  SE3 color_to_pose_ = SE3::Identity();
};

} // namespace kinora::ingest
