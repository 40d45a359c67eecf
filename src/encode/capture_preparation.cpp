#include "encode/capture_preparation.h"

#include <algorithm>
#include <array>
#include <functional>

#include <fmt/format.h>

#include "encode/held_out_frames.h"
#include "ingest/calibration/pose_consistency.h"
#include "ingest/frame/label_borders.h"
#include "ingest/joints/joint_detector.h"
#include "ingest/segmentation/mask_completion.h"
#include "ingest/segmentation/network_segmenter.h"
#include "ingest/segmentation/sample_views.h"
#include "ingest/segmentation/segmenter.h"

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

constexpr int kMaxRounds = 3;
constexpr std::size_t kMinPlanePixels = 800; ///< pixels of 19200
constexpr double kSamePath = 0.01;           // metres, and radians
constexpr double kMinConsistency = 0.7; // of what frames show; right paths have 0.78 to 0.95, wrong ones 0.64 to 0.78

double max_change(const CameraPath& before, const CameraPath& after) {
  double largest = 0;
  for (const auto& [frame, pose] : before.camera_to_world) {
    const auto found = after.camera_to_world.find(frame);
    const SE3 change = found == after.camera_to_world.end() ? pose : SE3(pose.inverse() * found->second);
    largest = std::max({largest, change.translation().norm(), rotation_angle(change)});
  }
  return largest;
}

using MakeSegmenter = std::function<std::unique_ptr<ingest::Segmenter>()>;

/// One way to understand the capture. What is found out makes another candidate; none is changed.
struct Candidate {
  ingest::CaptureOptions options;           ///< how it is opened: with its masks or without, how colour lies on depth
  std::shared_ptr<const CameraPath> camera; ///< where the camera was
  tracking::CameraTrackerConfig tracker;    ///< how the camera was followed, or is to be
};

struct ScoredCandidate {
  Candidate candidate;
  double consistency; ///< share of what the frames show that keeps still if the camera was where the path says
};

/// Makes candidates from others, and looks at the capture as they have it.
class Preparation {
public:
  /// `quiet` is for readings before the last one.
  Preparation(const CaptureRequest& request, StageTimes& times, Progress& progress, Progress& quiet)
      : request_(request), times_(times), progress_(progress), quiet_(quiet) {}

  /// As the request has it: its camera is still, or the frames say where it is.
  Candidate given() const {
    Candidate candidate{request_.options, std::make_shared<CameraPath>(), request_.camera};
    if (!request_.network.empty()) candidate.options.use_masks = false;
    return candidate;
  }

  std::unique_ptr<ingest::Capture> open(const Candidate& candidate) const {
    return opener(candidate, quiet_)(candidate.options.frames);
  }
  std::unique_ptr<ingest::Capture> labelled(const Candidate& candidate, std::unique_ptr<ingest::Segmenter> segmenter,
                                            Progress& progress) const {
    return ingest::segmented_capture(opener(candidate, progress), candidate.options.frames, std::move(segmenter),
                                     progress);
  }

  /// With the path along which the candidate's tracker follows the camera through frames that were opened as the
  /// candidate has them.
  Candidate followed(const Candidate& candidate, std::unique_ptr<ingest::Capture> frames) const {
    return {candidate.options,
            std::make_shared<CameraPath>(
                follow_camera(*frames, candidate.tracker, candidate.camera->depth_lag, times_, progress_)),
            candidate.tracker};
  }

  ScoredCandidate scored(Candidate candidate) const {
    const double consistency = ingest::photometric_geometric_consistency(
        ingest::sample_views(opener(candidate, quiet_), candidate.options.frames, quiet_));
    return {std::move(candidate), consistency};
  }

  /// What a search for another colour camera finds; nothing is looked for where one is told.
  ingest::FoundRegistration search_registration(const Candidate& candidate) const {
    if (candidate.options.registration) return {};
    return ingest::search_registration(*open(candidate), progress_);
  }

  /// What the candidate leaves out.
  std::unique_ptr<ingest::Capture> held_out(const Candidate& candidate) const {
    ingest::CaptureOptions how = candidate.options;
    how.use_masks = false;
    const HeldOutFrames frames{request_.holdout, request_.options.frames};
    return depth_in_time(
        frames_where(request_.open(how, progress_), [frames](int index) { return frames.contains(index); }),
        candidate.camera);
  }

private:
  ingest::CaptureFactory opener(const Candidate& candidate, Progress& progress) const {
    return [this, candidate, &progress](const FrameRange& range) {
      ingest::CaptureOptions how = candidate.options;
      how.frames = range;
      const HeldOutFrames held_out{request_.holdout, request_.options.frames};
      return posed_capture(
          frames_where(request_.open(how, progress), [held_out](int index) { return !held_out.contains(index); }),
          candidate.camera);
    };
  }

  const CaptureRequest& request_;
  StageTimes& times_;
  Progress& progress_;
  Progress& quiet_;
};

// Where walls are out of range, somebody who moves may be most of what is measured. So the camera is also followed by
// planes alone, of which a narrow strip of floor may be all there is, and may have kept still after all.
Candidate best_path(const Preparation& preparation, const Candidate& followed, Progress& quiet) {
  const auto nothing_better = std::make_shared<CameraPath>();
  nothing_better->origin = CameraPath::Origin::kNothingBetter;
  const Candidate still{followed.options, nothing_better, followed.tracker};
  Candidate of_little = followed;
  of_little.tracker.min_pixels = kMinPlanePixels;
  of_little.tracker.frames_to_move = 0;
  const Candidate by_planes =
      preparation.followed(of_little, preparation.labelled(of_little, ingest::make_plane_segmenter(), quiet));
  const std::array<ScoredCandidate, 3> candidates{preparation.scored(still), preparation.scored(followed),
                                                  preparation.scored(by_planes)};
  // The first of those that explain most: what moves less.
  return std::max_element(candidates.begin(), candidates.end(),
                          [](const auto& a, const auto& b) { return a.consistency < b.consistency; })
      ->candidate;
}

void warn_of_inconsistency(double consistency, Progress& progress) {
  if (consistency >= kMinConsistency) return;
  progress.warn(fmt::format("where the camera was cannot be told for certain: along the path that was found only "
                            "{:.0f} % of what the frames show keeps still, and what was followed may be something "
                            "that moves; masks, or a pose for every frame, would tell",
                            100 * consistency));
}

// What moves misleads who follows the camera, and a wrong path whoever tells what moves: by turns.
Candidate followed_by_background(const Preparation& preparation, const Candidate& begin,
                                 const MakeSegmenter& make_segmenter, Progress& progress, Progress& quiet) {
  ScoredCandidate best = preparation.scored(begin);
  for (int round = 0; round < kMaxRounds; ++round) {
    const Candidate& before = best.candidate;
    ScoredCandidate next =
        preparation.scored(preparation.followed(before, preparation.labelled(before, make_segmenter(), quiet)));
    const bool too_little_was_left =
        next.candidate.camera->lost > before.camera->lost || next.consistency < best.consistency;
    if (too_little_was_left) break;
    const bool settled = max_change(*before.camera, *next.candidate.camera) < kSamePath;
    best = std::move(next);
    if (settled) break;
  }
  warn_of_inconsistency(best.consistency, progress);
  return best.candidate;
}

void warn_of_registration(const ingest::RegistrationGeometry& found, Progress& progress) {
  progress.warn(fmt::format("colour and depth are not one camera's, as the capture says: colour has a focal "
                            "length of {:.1f} pixels, depth {:.1f}; depth is carried into colour",
                            found.color.fx, found.depth.fx));
}

Candidate with_registration(const Candidate& candidate, const ingest::FoundRegistration& found) {
  Candidate registered = candidate;
  if (found.geometry) registered.options.registration = found.geometry;
  return registered;
}

/// Lays labels on edges where they miss them.
class OnEdges final : public ingest::Segmenter {
public:
  explicit OnEdges(std::unique_ptr<ingest::Segmenter> segmenter) : segmenter_(std::move(segmenter)) {}
  void prepare(const ingest::CaptureFactory& open, const FrameRange& range, Progress& progress) override {
    segmenter_->prepare(open, range, progress);
  }
  void label(ingest::Frame& frame) override {
    segmenter_->label(frame);
    ingest::repair_borders(frame);
  }
  const std::map<int, ingest::LabelInfo>& labels() const override { return segmenter_->labels(); }

private:
  std::unique_ptr<ingest::Segmenter> segmenter_;
};

/// Who labels the frames.
struct Labelling {
  std::string from; ///< in words
  MakeSegmenter make_segmenter;
};

Labelling labelling_of(const CaptureRequest& request, bool has_masks) {
  if (!request.network.empty()) {
    return {"network " + request.network.filename().string(),
            [network = request.network, on_edges = request.options.masks_on_edges] {
              auto segmenter = ingest::make_network_segmenter(network);
              return on_edges ? std::make_unique<OnEdges>(std::move(segmenter)) : std::move(segmenter);
            }};
  }
  if (has_masks) return {"masks", ingest::make_mask_completion};
  return {"motion", ingest::make_motion_segmenter};
}

} // namespace

PreparedCapture prepare_capture(const CaptureRequest& request, Progress& progress) {
  // A network that is none is known before the work begins.
  auto detector = request.detector.empty() ? nullptr : ingest::make_network_detector(request.detector);
  if (!request.network.empty()) (void)ingest::make_network_segmenter(request.network);

  StageTimes times;
  QuietProgress quiet(progress);
  const Preparation preparation(request, times, progress, quiet);
  const Candidate given = preparation.given();
  const ingest::CaptureInfo info = preparation.open(given)->info();
  const Labelling labelling = labelling_of(request, info.has_masks);
  const auto may_be_elsewhere = [&](const Candidate& candidate) { // masks say what moves
    return candidate.camera->moves() && !info.has_masks;
  };
  const Candidate followed =
      info.has_poses
          ? given
          : preparation.followed(given, info.has_masks ? preparation.labelled(given, labelling.make_segmenter(), quiet)
                                                       : preparation.open(given));
  const Candidate placed = may_be_elsewhere(followed) ? best_path(preparation, followed, quiet) : followed;
  const ingest::FoundRegistration registration = preparation.search_registration(placed);
  if (registration.geometry) warn_of_registration(*registration.geometry, progress);
  const Candidate registered = with_registration(placed, registration);
  const Candidate best = may_be_elsewhere(registered)
                             ? followed_by_background(preparation, registered,
                                                      request.network.empty() ? ingest::make_foreground_segmenter
                                                                              : labelling.make_segmenter,
                                                      progress, quiet)
                             : registered;

  PreparedCapture prepared;
  prepared.capture = preparation.labelled(best, labelling.make_segmenter(), progress);
  if (request.holdout > 0) prepared.held_out = preparation.held_out(best);
  prepared.camera = best.camera;
  prepared.registration = registration;
  prepared.labels_from = labelling.from;
  if (detector) {
    prepared.joints_from = "network " + request.detector.filename().string();
    prepared.capture = ingest::detected_capture(std::move(prepared.capture), std::move(detector));
  }
  prepared.times = std::move(times);
  return prepared;
}

} // namespace kinora::encode
