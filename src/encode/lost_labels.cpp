#include "encode/lost_labels.h"

#include <algorithm>

#include <fmt/format.h>

#include "core/sensor_noise.h"

namespace kinora::encode {
namespace {

constexpr std::size_t kFramesCompared = 8;    ///< of those that show a label
constexpr std::size_t kPixelsCompared = 2000; ///< of a label, of each of these frames
constexpr double kStill = 0.5;

bool shows(const fields::StoredPixel& pixel, int label) { return pixel.label == label && pixel.depth.is_measured(); }

std::vector<const fields::StoredFrame*> frames_showing(const fields::PixelStore& pixels, int label) {
  std::vector<const fields::StoredFrame*> frames;
  for (const fields::StoredFrame& frame : pixels.frames()) {
    const auto* first = pixels.pixels().data() + frame.begin;
    const auto* last = pixels.pixels().data() + frame.end;
    if (std::any_of(first, last, [label](const auto& pixel) { return shows(pixel, label); })) frames.push_back(&frame);
  }
  return frames;
}

DepthImage depth_of(const fields::PixelStore& pixels, const fields::StoredFrame& frame) {
  DepthImage depth(frame.camera.intrinsics.width, frame.camera.intrinsics.height);
  for (std::size_t i = frame.begin; i < frame.end; ++i) {
    const fields::StoredPixel& pixel = pixels.pixels()[i];
    if (pixel.depth.is_measured()) depth.at(pixel.u, pixel.v) = pixel.depth.metres();
  }
  return depth;
}

std::vector<Eigen::Vector3d> points_of(const fields::PixelStore& pixels, const fields::StoredFrame& frame, int label) {
  std::vector<Eigen::Vector3d> points;
  for (std::size_t i = frame.begin; i < frame.end; ++i) {
    const fields::StoredPixel& pixel = pixels.pixels()[i];
    if (!shows(pixel, label)) continue;
    points.push_back(frame.camera.camera_to_world *
                     frame.camera.intrinsics.unproject(pixel.u, pixel.v, pixel.depth.metres()));
  }
  const std::size_t step = 1 + points.size() / kPixelsCompared;
  std::vector<Eigen::Vector3d> some;
  for (std::size_t i = 0; i < points.size(); i += step) some.push_back(points[i]);
  return some;
}

/// How often a frame sees points where they are, and how often it sees past them.
struct Sightings {
  std::size_t there = 0, past = 0;

  void add(const std::vector<Eigen::Vector3d>& points, const Camera& camera, const DepthImage& depth) {
    const SE3 world_to_camera = camera.camera_to_world.inverse();
    for (const Eigen::Vector3d& world : points) {
      const Eigen::Vector3d point = world_to_camera * world;
      if (point.z() <= 0) continue;
      const Eigen::Vector2d pixel = camera.intrinsics.project(point);
      const double u = std::round(pixel.x());
      const double v = std::round(pixel.y());
      if (!(u >= 0 && v >= 0 && u < depth.width() && v < depth.height())) continue;
      const double seen = depth.at(static_cast<int>(u), static_cast<int>(v));
      const double tolerance = kThreeSigmaOfDifference * kSensorNoise.sigma(point.z());
      if (seen <= 0 || seen < point.z() - tolerance) continue;
      ++(seen > point.z() + tolerance ? past : there);
    }
  }
};

bool is_lost_mostly(const TrackedLabel& label, const std::vector<const fields::StoredFrame*>& shown) {
  const motion::Motion motion = label.motion();
  if (motion.kind() == motion::MotionKind::kStill) return false;
  const auto lost = std::count_if(shown.begin(), shown.end(), [&](const fields::StoredFrame* frame) {
    return motion.health(static_cast<std::size_t>(frame->frame)) == motion::Health::kLost;
  });
  return 2 * static_cast<std::size_t>(lost) > shown.size();
}

bool is_from_segmenter(int label, const ingest::CaptureInfo& capture) {
  const auto found = capture.labels.find(label);
  return found != capture.labels.end() && !found->second.why.empty();
}

} // namespace

double still_share(const fields::PixelStore& pixels, int label) {
  const std::vector<const fields::StoredFrame*> shown = frames_showing(pixels, label);
  const std::size_t count = std::min(kFramesCompared, shown.size());
  std::vector<const fields::StoredFrame*> compared;
  for (std::size_t i = 0; i < count; ++i)
    compared.push_back(shown[count == 1 ? 0 : i * (shown.size() - 1) / (count - 1)]);
  Sightings sightings;
  for (const fields::StoredFrame* seen_in : compared) {
    const DepthImage depth = depth_of(pixels, *seen_in);
    for (const fields::StoredFrame* frame : compared) {
      if (frame != seen_in) sightings.add(points_of(pixels, *frame, label), seen_in->camera, depth);
    }
  }
  const std::size_t told = sightings.there + sightings.past;
  return told == 0 ? 0 : static_cast<double>(sightings.there) / static_cast<double>(told);
}

std::vector<NotModelled> drop_lost_labels(FramePass& pass, const ingest::CaptureInfo& capture) {
  std::vector<NotModelled> dropped;
  for (auto it = pass.labels.begin(); it != pass.labels.end();) {
    const auto& [number, label] = *it;
    const std::vector<const fields::StoredFrame*> shown = frames_showing(pass.pixels, number);
    if (number == 0 || !is_from_segmenter(number, capture) || !is_lost_mostly(label, shown)) {
      ++it;
      continue;
    }
    const double still = still_share(pass.pixels, number);
    const bool joins_room = still >= kStill && pass.labels.contains(0);
    dropped.push_back(
        {label.plan.name, number,
         fmt::format("it is lost in most frames that show it, and {:.0f} % of it is seen at one place: {}", 100 * still,
                     joins_room ? "the background has it" : "nothing is made of it")});
    if (joins_room) pass.pixels.relabel(number, 0);
    it = pass.labels.erase(it);
  }
  return dropped;
}

} // namespace kinora::encode
