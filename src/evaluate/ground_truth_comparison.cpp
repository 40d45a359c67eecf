#include "evaluate/ground_truth_comparison.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/parallel.h"
#include "evaluate/comparison.h"

namespace kinora::evaluate {
namespace {

using Json = nlohmann::json;

constexpr int kObjectLabel = 2; ///< of the object that a capture's truth speaks of

double rounded(double value) { return std::round(value * 1e5) / 1e5; }

/// Running mean and maximum.
struct Spread {
  double sum = 0;
  double largest = 0;
  int count = 0;

  void add(double value) {
    sum += value;
    largest = std::max(largest, value);
    ++count;
  }
  double mean() const { return sum / count; }
};

// Where a true object stands at a frame of the clip; nothing if the truth does not say.
std::optional<SE3> true_pose(const clip::Clip& clip, const GroundTruth& truth, std::size_t frame) {
  const auto found = truth.object_to_camera().find(clip.capture_frames[frame]);
  if (found == truth.object_to_camera().end()) return std::nullopt;
  return clip.capture_camera(static_cast<double>(frame)).camera_to_world * found->second;
}

std::optional<std::size_t> first_common_frame(const clip::Clip& clip, const clip::Layer& layer,
                                              const GroundTruth& truth) {
  for (std::size_t i = 0; i < clip.times.size(); ++i) {
    if (layer.motion.health(i) != motion::Health::kLost && true_pose(clip, truth, i)) return i;
  }
  return std::nullopt;
}

Json object_pose_json(const player::Player& player, const GroundTruth& truth) {
  const clip::Clip& clip = player.clip();
  const auto index = player.layer_with_label(kObjectLabel);
  if (!index || truth.object_to_camera().empty()) return nullptr;
  const clip::Layer& layer = clip.layers[*index];
  const auto first = first_common_frame(clip, layer, truth);
  if (!first || layer.motion.kind() == motion::MotionKind::kDeforming) return nullptr;
  const SE3 first_truth = true_pose(clip, truth, *first).value();
  const SE3 first_drawn = layer.motion.canonical_to_world(static_cast<double>(*first));
  const Eigen::Vector3d centroid = truth.object_centroid().value_or(Eigen::Vector3d::Zero());
  Spread distance;
  Spread angle;
  for (std::size_t i = *first + 1; i < clip.times.size(); ++i) {
    const auto now = true_pose(clip, truth, i);
    if (!now) continue;
    const SE3 moved = layer.motion.canonical_to_world(static_cast<double>(i)) * first_drawn.inverse();
    const SE3 wanted = *now * first_truth.inverse();
    const Eigen::Vector3d point = first_truth * centroid;
    distance.add((moved * point - wanted * point).norm());
    angle.add(rotation_angle(moved * wanted.inverse()) * 180 / std::numbers::pi);
  }
  if (distance.count == 0) return nullptr;
  return {{"layer", layer.name},
          {"frames", distance.count},
          {"error_m_mean", rounded(distance.mean())},
          {"error_m_max", rounded(distance.largest)},
          {"error_degrees_mean", rounded(angle.mean())},
          {"error_degrees_max", rounded(angle.largest)}};
}

// The novel camera's picture in the form of a captured frame.
ingest::Frame frame_of(const GroundTruth& truth, const NovelCamera& camera, int number) {
  NovelView view = truth.novel_view(camera, number);
  ingest::Frame frame;
  frame.index = number;
  frame.camera = camera.camera;
  frame.color = std::move(view.color);
  frame.depth = view.depth.empty() ? DepthImage(frame.color.width(), frame.color.height()) : std::move(view.depth);
  frame.labels = std::move(view.mask);
  return frame;
}

std::optional<std::size_t> clip_frame(const clip::Clip& clip, int capture_frame) {
  const auto& numbers = clip.capture_frames;
  const auto found = std::find(numbers.begin(), numbers.end(), capture_frame);
  if (found == numbers.end()) return std::nullopt;
  return static_cast<std::size_t>(found - numbers.begin());
}

Json camera_json(const player::Player& player, const GroundTruth& truth, const NovelCamera& camera,
                 const std::vector<Subject>& subjects, const Progress& progress) {
  std::vector<Means> means(subjects.size());
  for (const int number : camera.frames) {
    const auto i = clip_frame(player.clip(), number);
    if (!i) continue;
    progress.check();
    const ingest::Frame frame = frame_of(truth, camera, number);
    std::vector<fields::Picture> pictures;
    pictures.reserve(subjects.size());
    for (const Subject& subject : subjects) {
      pictures.push_back(player.draw(camera.camera, static_cast<double>(*i), subject.layers));
    }
    parallel_for(subjects.size(), 1, [&](const Chunk& chunk) {
      compare(pictures[chunk.index], frame, subjects[chunk.index], means[chunk.index]);
    });
  }
  Json out = {{"name", camera.name}, {"layers", Json::array()}};
  for (std::size_t k = 0; k < subjects.size(); ++k) {
    Json layer = means[k].json();
    layer["name"] = subjects[k].name;
    layer["region"] = subjects[k].region;
    out["layers"].push_back(std::move(layer));
  }
  return out;
}

} // namespace

Json compare_with_ground_truth(const player::Player& player, const GroundTruth& truth, Progress& progress) {
  const bool masks = player.clip().layers.size() > 1 || player.layer_with_label(0) == std::nullopt;
  std::vector<Subject> subjects = layer_subjects(player, masks);
  if (auto foreground = foreground_subject(player)) subjects.push_back(std::move(*foreground));
  progress.stage("comparing from novel cameras", truth.novel_cameras().size());
  Json cameras = Json::array();
  for (const NovelCamera& camera : truth.novel_cameras()) {
    cameras.push_back(camera_json(player, truth, camera, subjects, progress));
    progress.advance(cameras.size(), "");
  }
  return {{"object_pose", object_pose_json(player, truth)}, {"novel_cameras", std::move(cameras)}};
}

} // namespace kinora::evaluate
