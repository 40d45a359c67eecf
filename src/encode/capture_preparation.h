// From a capture as it was recorded to one that can be encoded: its frames know where the camera was, colour lies on
// depth, and pixels are labelled.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "encode/camera_path.h"
#include "ingest/calibration/registration_search.h"

namespace kinora::encode {

/// What to prepare.
struct CaptureRequest {
  /// Opens the capture anew, from its first frame on.
  std::function<std::unique_ptr<ingest::Capture>(const ingest::CaptureOptions&, Progress&)> open;
  ingest::CaptureOptions options;       ///< with a registration none is looked for
  tracking::CameraTrackerConfig camera; ///< how the camera of a capture without poses is followed
  std::filesystem::path network;        ///< labels the frames, instead of masks; empty: none
  std::filesystem::path detector;       ///< finds joints of people; empty: none
  int holdout = 0;                      ///< every such frame of the range is read by nothing (HeldOutFrames); 0: none
};

struct PreparedCapture {
  std::unique_ptr<ingest::Capture> capture; ///< without frames that are held out
  /// The frames that are held out, without labels and as the capture has them; null: there are none.
  std::unique_ptr<ingest::Capture> held_out;
  std::shared_ptr<const CameraPath> camera = std::make_shared<CameraPath>(); ///< where the capture has no poses
  ingest::FoundRegistration registration;
  std::string labels_from; ///< in words: "masks", "motion", or the network
  std::string joints_from; ///< in words: the detector; empty: none
  StageTimes times;        ///< of what was done so far
};

/// Reads the capture several times. Where it brings no poses its camera is followed; if it moves, also by wide
/// planes alone, and the path along which most of what is seen keeps still is taken
/// (ingest::photometric_geometric_consistency). Colour is then compared with depth, what moves is told from the
/// background with these poses, and the camera is followed again without it until its path stays the same or explains
/// less. A path that explains little is warned of. Labels come from the network if there is one, else from masks, else
/// from motion, and joints from the detector. Same capture, same bits, for any number of threads. Throws what reading,
/// segmenters, the network and the detector throw.
PreparedCapture prepare_capture(const CaptureRequest& request, Progress& progress);

} // namespace kinora::encode
