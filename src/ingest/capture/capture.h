// A capture as a stream of frames: opened through a format plugin, synchronised, cleaned and numbered.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/frame_range.h"
#include "core/progress.h"
#include "host/options.h"
#include "ingest/depth/depth_cleaning.h"
#include "ingest/depth/registration.h"
#include "ingest/frame/frame.h"

namespace kinora::host {
class PluginTable;
class SimulatedDevice;
} // namespace kinora::host

namespace kinora::ingest {

struct CaptureOptions {
  std::string format;           ///< name of the format to read with; empty: whoever recognises it best
  host::Options format_options; ///< of that format
  FrameRange frames;
  bool use_masks = true;       ///< false: masks on disk are not read
  bool masks_on_edges = false; ///< masks whose borders miss the picture's edges are laid on them (repair_borders)
  double max_depth = 20; ///< metres: no depth camera measures beyond; some mark "no measurement" with large values
  DepthCleaning cleaning;
  /// The two cameras of a capture that says colour and depth are one camera's; its poses are then the depth camera's.
  std::optional<RegistrationGeometry> registration;
  std::shared_ptr<host::SimulatedDevice> device; ///< from which the frames come live; null: they are there at once
};

/// How a label is to be modelled, from the capture's labels.json or from a segmenter.
struct LabelInfo {
  std::string name;
  std::string kind; ///< "deforming", "rigid", "still", or empty: decided by label (1 deforming, 2… rigid)
  std::string why;  ///< one clause for the report, from a segmenter only
};

struct CaptureInfo {
  std::string format;    ///< name of the plugin that reads it
  Intrinsics intrinsics; ///< of the frames as delivered
  int frame_count = 0;   ///< frames in the source, before range and skipping
  double frames_per_second = 30;
  bool has_poses = false; ///< camera_to_world of every frame comes from the capture
  bool has_masks = false;
  bool has_depth_camera = false; ///< depth comes from a camera of its own, says the capture, and is registered
  std::optional<RegistrationGeometry> registration; ///< as in CaptureOptions: what the frames were corrected by
  std::map<int, LabelInfo> labels;                  ///< by label; only what the capture says
};

struct SkippedFrame {
  int index;
  std::string reason; ///< one sentence that names the file
};

/// Pull reader. Not thread-safe.
class Capture {
public:
  /// Throws Error: kNotRecognised if no plugin knows it, kCorruptInput if one does but it cannot be read, kUsage if a
  /// registration is given that does not fit it, or an option that the format has not.
  static std::unique_ptr<Capture> open(const host::PluginTable& plugins, const std::filesystem::path& path,
                                       const CaptureOptions& options, Progress& progress);
  virtual ~Capture() = default;

  virtual const CaptureInfo& info() const = 0;
  /// The next usable frame within the range. A bad frame (missing, truncated, wrong size or type, without any depth)
  /// is warned of through Progress, counted in `skipped()` and passed over; nothing at the end. Infrared images that a
  /// plugin delivers are not used, which is warned of once.
  /// Throws Error(kCorruptInput) when more than half of the frames are bad, and Error(kInterrupted).
  virtual std::optional<Frame> next() = 0;
  virtual const std::vector<SkippedFrame>& skipped() const = 0;
  /// Frames that a device lost before the last one that next() gave.
  virtual std::size_t dropped() const { return 0; }
  /// Seconds since the last frame that next() gave was captured; 0 without a device.
  virtual double age() const { return 0; }
};

} // namespace kinora::ingest
