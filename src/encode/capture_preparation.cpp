#include "encode/capture_preparation.h"

#include <algorithm>

#include <fmt/format.h>

#include "ingest/explained_surface.h"
#include "ingest/joint_detector.h"
#include "ingest/mask_completion.h"
#include "ingest/network_segmenter.h"
#include "ingest/sample_views.h"
#include "ingest/segmenter.h"

namespace kinora::encode {
namespace {

/// Passes everything on but warnings: the last reading of a capture repeats them.
class QuietProgress final : public Progress {
public:
  explicit QuietProgress(Progress& to) : to_(to) {}
  void stage(const std::string& name, std::size_t total) override { to_.stage(name, total); }
  void advance(std::size_t done, const std::string& detail) override { to_.advance(done, detail); }
  bool cancelled() const override { return to_.cancelled(); }

private:
  Progress& to_;
};

constexpr int kMostRounds = 3;
constexpr std::size_t kLeastOfPlanes = 800; ///< pixels of 19200
constexpr double kSamePath = 0.01;          // metres, and radians
constexpr double kLeastExplained = 0.7; // of what frames show; right paths have 0.78 to 0.95, wrong ones 0.64 to 0.78

double largest_change(const CameraPath& before, const CameraPath& after) {
  double largest = 0;
  for (const auto& [frame, pose] : before.camera_to_world) {
    const auto found = after.camera_to_world.find(frame);
    const SE3 change = found == after.camera_to_world.end() ? pose : SE3(pose.inverse() * found->second);
    largest = std::max({largest, change.translation().norm(), rotation_angle(change)});
  }
  return largest;
}

class Preparation {
public:
  Preparation(const CaptureRequest& request, Progress& progress)
      : request_(request), options_(request.options), progress_(progress), quiet_(progress), tracker_(request.camera) {
    // A network that is none is known before the work begins.
    if (!request.detector.empty()) {
      detector_ = ingest::make_network_detector(request.detector);
      result_.joints_from = "network " + request.detector.filename().string();
    }
    if (request.network.empty()) return;
    options_.use_masks = false;
    (void)segmenter();
  }

  PreparedCapture run() {
    const ingest::CaptureInfo info = open(quiet_)->info();
    has_masks_ = info.has_masks;
    if (!info.has_poses) follow(has_masks_ ? *labelled(segmenter(), quiet_) : *open(quiet_));
    if (result_.camera->moves() && !has_masks_) choose_path();
    find_registration();
    if (result_.camera->moves() && !has_masks_) follow_background();
    result_.capture = labelled(segmenter(), progress_);
    if (detector_) result_.capture = ingest::detected_capture(std::move(result_.capture), std::move(detector_));
    return std::move(result_);
  }

private:
  std::unique_ptr<ingest::Capture> open(Progress& progress) const {
    return placed_capture(request_.open(options_, progress), result_.camera);
  }

  ingest::CaptureFactory opener(Progress& progress) const {
    return [this, &progress](const ingest::FrameRange& range) {
      ingest::CaptureOptions how = options_;
      how.frames = range;
      return placed_capture(request_.open(how, progress), result_.camera);
    };
  }

  void follow(ingest::Capture& capture) {
    result_.camera = std::make_shared<CameraPath>(follow_camera(capture, tracker_, result_.times, progress_));
  }

  // How much of what the frames show keeps still if the camera was where the path says.
  double explained() {
    return ingest::explained_surface(ingest::sample_views(opener(quiet_), options_.frames, quiet_));
  }

  // Where walls are out of range, somebody who moves may be most of what is measured. So the camera is also followed by
  // planes alone, of which a narrow strip of floor may be all there is, and may have kept still after all.
  void choose_path() {
    std::shared_ptr<const CameraPath> best = result_.camera;
    double most = explained();
    const tracking::CameraTrackerConfig usual = tracker_;
    tracking::CameraTrackerConfig of_little = usual;
    of_little.min_pixels = kLeastOfPlanes;
    of_little.frames_to_move = 0;
    tracker_ = of_little;
    follow(*labelled(ingest::make_plane_segmenter(), quiet_));
    if (const double share = explained(); share > most) {
      best = result_.camera;
      most = share;
    } else {
      tracker_ = usual;
    }
    auto still = std::make_shared<CameraPath>();
    still->report = {{"path", "still"}, {"why", "no path that was found explains the pictures better"}};
    result_.camera = still;
    if (explained() < most) result_.camera = best;
  }

  // What moves misleads who follows the camera, and a wrong path whoever tells what moves: by turns.
  void follow_background() {
    double share = explained();
    for (int round = 0; round < kMostRounds; ++round) {
      const std::shared_ptr<const CameraPath> before = result_.camera;
      const double share_before = share;
      follow(*labelled(request_.network.empty() ? ingest::make_foreground_segmenter() : segmenter(), quiet_));
      share = explained();
      if (result_.camera->lost > before->lost || share < share_before) { // too little was left to follow
        result_.camera = before;
        share = share_before;
        break;
      }
      if (largest_change(*before, *result_.camera) < kSamePath) break;
    }
    warn_of_doubt(share);
  }

  void warn_of_doubt(double share) {
    if (share >= kLeastExplained) return;
    progress_.warn(fmt::format("where the camera was cannot be told for certain: along the path that was found only "
                               "{:.0f} % of what the frames show keeps still, and what was followed may be something "
                               "that moves; masks, or a pose for every frame, would tell",
                               100 * share));
  }

  void find_registration() {
    if (options_.registration) return;
    result_.registration = ingest::search_registration(*open(quiet_), progress_);
    if (!result_.registration.geometry) return;
    options_.registration = result_.registration.geometry;
    progress_.warn(fmt::format("colour and depth are not one camera's, as the capture says: colour has a focal "
                               "length of {:.1f} pixels, depth {:.1f}; depth is carried into colour",
                               options_.registration->color.fx, options_.registration->depth.fx));
  }

  std::unique_ptr<ingest::Segmenter> segmenter() {
    if (!request_.network.empty()) {
      result_.labels_from = "network " + request_.network.filename().string();
      return ingest::make_network_segmenter(request_.network);
    }
    result_.labels_from = has_masks_ ? "masks" : "motion";
    return has_masks_ ? ingest::make_mask_completion() : ingest::make_motion_segmenter();
  }

  std::unique_ptr<ingest::Capture> labelled(std::unique_ptr<ingest::Segmenter> segmenter, Progress& progress) {
    return ingest::segmented_capture(opener(progress), options_.frames, std::move(segmenter), progress);
  }

  const CaptureRequest& request_;
  ingest::CaptureOptions options_;
  Progress& progress_;
  QuietProgress quiet_;
  tracking::CameraTrackerConfig tracker_; ///< how the camera is followed
  PreparedCapture result_;
  std::unique_ptr<ingest::JointDetector> detector_;
  bool has_masks_ = false;
};

} // namespace

PreparedCapture prepare_capture(const CaptureRequest& request, Progress& progress) {
  return Preparation(request, progress).run();
}

} // namespace kinora::encode
