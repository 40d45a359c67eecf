#include "encode/camera_refinement.h"

#include <algorithm>
#include <cmath>

#include "core/rolling_shutter.h"
#include "core/statistics.h"
#include "encode/readout_search.h"
#include "fields/sampling/row_depth.h"

namespace kinora::encode {
namespace {

using Corrections = std::vector<std::optional<PoseCorrection>>;

const LayerJob* background_of(const TrainingPlan& plan) {
  const auto found = std::ranges::find_if(plan.layers, [](const LayerJob& job) {
    return job.label->plan.label == 0 && job.label->motion().kind() == motion::MotionKind::kStill;
  });
  return found == plan.layers.end() ? nullptr : &*found;
}

/// How the camera moves in the world, in each frame of the timeline.
std::vector<SE3> moves_of(const Corrections& corrections, const std::vector<fields::StoredFrame>& frames,
                          const std::vector<SE3>& path) {
  std::vector<std::optional<Twist>> found(path.size());
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const auto f = static_cast<std::size_t>(frames[k].frame);
    if (corrections[k]) found[f] = log_se3(corrections[k]->canonical_from_camera * path[f].inverse());
  }
  std::vector<SE3> moves(path.size(), SE3::Identity());
  for (std::size_t f = 0; f < path.size(); ++f) {
    std::vector<Twist> twists;
    if (found[f]) {
      twists = {*found[f]};
    } else {
      if (f > 0 && found[f - 1]) twists.push_back(*found[f - 1]);
      if (f + 1 < path.size() && found[f + 1]) twists.push_back(*found[f + 1]);
    }
    Twist mean = Twist::Zero();
    for (const Twist& twist : twists) mean += twist / static_cast<double>(twists.size());
    moves[f] = exp_se3(mean);
  }
  return moves;
}

// What is seen keeps its place before the camera.
void move(FramePass& pass, const std::vector<SE3>& moves) {
  std::vector<SE3>& path = pass.clip.camera_to_world;
  for (std::size_t f = 0; f < path.size(); ++f) path[f] = renormalized(moves[f] * path[f]);
  pass.pixels.set_cameras(path);
  for (auto& [label, tracked] : pass.labels) tracked.move_world(moves);
}

// Rays of each row begin where the camera was when colour was read; depth that was read otherwise is carried there, by
// what is returned, if it has been carried by so many seconds.
double carry_rows(FramePass& pass, const ReadoutSearch& readout, double carried) {
  constexpr double kLeastCarried = 0.001; // seconds
  const auto motion = [&](double seconds) {
    return readout_motion(pass.clip.camera_to_world, pass.clip.times, seconds);
  };
  pass.pixels.set_readout(motion(readout.color()));
  const double carry = readout.color() - readout.depth() - carried;
  if (std::abs(carry) < kLeastCarried) return 0;
  fields::carry_depth_to_rows(pass.pixels, motion(carry));
  return carry;
}

double time_between_frames(const std::vector<double>& times) {
  std::vector<double> between;
  for (std::size_t f = 1; f < times.size(); ++f) between.push_back(times[f] - times[f - 1]);
  return median(between);
}

} // namespace

std::optional<CameraRefinement> refine_camera(FramePass& pass, const TrainingPlan& plan, const EncodeOptions& options,
                                              StageTimes& times, Progress& progress) {
  const PoseRefinementConfig& config = options.settings.fields.poses;
  const LayerJob* background = background_of(plan);
  const std::vector<SE3>& path = pass.clip.camera_to_world;
  if (background == nullptr || path.size() < 2 || config.passes == 0) return std::nullopt;
  const motion::Motion still = motion::Motion::still();
  const fields::LayerObservations observations{pass.pixels, background->label->plan.label, still};
  const LayerOutcome outcome = prepare_layer(*background, observations, options);
  const std::vector<SE3> before = path;
  CameraRefinement refinement;
  ReadoutSearch readout(time_between_frames(pass.clip.times));
  double carried = 0; // seconds by which the rows of depth are later than they were read
  for (int n = 0, passes = config.passes; n < passes; ++n) {
    progress.stage("training a draft of " + background->name, 0);
    fields::TrainingReport training;
    refinement.draft.field = times.measure("train a draft of " + background->name, [&] {
      return fields::train_field(observations, outcome.config, draft_trainer(outcome.trainer), progress, &training,
                                 n > 0 ? &refinement.draft.field : nullptr);
    });
    refinement.draft.rays += training.rays;
    progress.stage("refining the camera's path", pass.pixels.frames().size());
    const Corrections corrections = times.measure("refine the camera's path", [&] {
      return refine_poses(refinement.draft.field, observations, readout_motion(path, pass.clip.times, 1), progress,
                          config);
    });
    std::vector<ColorFit> fits;
    for (const auto& correction : corrections) {
      if (correction) fits.push_back(correction->fit);
    }
    refinement.frames = fits.size();
    if (fits.empty()) break;
    const auto mean = [&](double ColorFit::*value) {
      double sum = 0;
      for (const ColorFit& fit : fits) sum += fit.*value;
      return sum / static_cast<double>(fits.size());
    };
    if (n == 0) refinement.color_before = mean(&ColorFit::before);
    refinement.color_after = mean(&ColorFit::after);
    move(pass, moves_of(corrections, pass.pixels.frames(), path));
    if (readout.look(corrections)) ++passes;
    carried += carry_rows(pass, readout, carried);
  }
  refinement.readout = {readout.color(), readout.depth()};
  std::vector<double> metres, radians;
  for (std::size_t f = 0; f < path.size(); ++f) {
    refinement.corrections.push_back(path[f] * before[f].inverse());
    metres.push_back((path[f].translation() - before[f].translation()).norm());
    radians.push_back(rotation_angle(before[f].inverse() * path[f]));
  }
  refinement.metres = median(metres);
  refinement.radians = median(radians);
  return refinement;
}

} // namespace kinora::encode
