#include "encode/layer_presence.h"

#include <algorithm>

#include "core/sensor_noise.h"
#include "fields/sampling/pixel_map.h"
#include "motion/point_track.h"

namespace kinora::encode {
namespace {

constexpr std::size_t kMargin = 3;           ///< frames beside those that show it at which it still counts as there
constexpr std::size_t kFramesLookedAt = 8;   ///< of those at which it may be away
constexpr std::size_t kPointsLookedAt = 500; ///< of its surface
constexpr std::size_t kMinTold = 50;         ///< looks at points that say anything, over all these frames
constexpr double kSeenThrough = 0.9;         ///< share of them

/// What one stored frame shows of the label, in the world.
std::vector<Eigen::Vector3d> surface_in(const fields::PixelStore& pixels, const fields::StoredFrame& frame, int label) {
  std::vector<Eigen::Vector3d> all;
  for (std::size_t i = frame.begin; i < frame.end; ++i) {
    const fields::StoredPixel& pixel = pixels.pixels()[i];
    if (pixel.label != label || !pixel.depth.is_measured()) continue;
    all.push_back(frame.camera.camera_to_world *
                  frame.camera.intrinsics.unproject(pixel.u, pixel.v, pixel.depth.metres()));
  }
  const std::size_t step = 1 + all.size() / kPointsLookedAt;
  std::vector<Eigen::Vector3d> some;
  for (std::size_t i = 0; i < all.size(); i += step) some.push_back(all[i]);
  return some;
}

/// How many looks at points say anything: whether the point is there, or is seen through.
struct Looks {
  std::size_t told = 0;
  std::size_t through = 0;
};

void look(const fields::PixelStore& pixels, const fields::StoredFrame& frame,
          const std::vector<std::vector<Eigen::Vector3d>>& tracks, Looks& looks) {
  const fields::PixelMap picture(pixels, frame);
  const SE3 world_to_camera = frame.camera.camera_to_world.inverse();
  for (const std::vector<Eigen::Vector3d>& track : tracks) {
    const Eigen::Vector3d point = world_to_camera * track[static_cast<std::size_t>(frame.frame)];
    if (!(point.z() > 0)) continue;
    const Eigen::Vector2d at = frame.camera.intrinsics.project(point);
    const Intrinsics& size = frame.camera.intrinsics;
    if (!(at.x() >= 0 && at.y() >= 0 && at.x() <= size.width - 1 && at.y() <= size.height - 1)) continue;
    const auto* const pixel = picture.at(static_cast<int>(std::lround(at.x())), static_cast<int>(std::lround(at.y())));
    if (pixel == nullptr || !pixel->depth.is_measured()) continue;
    const double behind = pixel->depth.metres() - point.z();
    const double tolerance = kThreeSigmaOfDifference * kSensorNoise.sigma(point.z());
    if (behind < -tolerance) continue; // something stands before it
    ++looks.told;
    looks.through += behind > tolerance ? 1 : 0;
  }
}

/// Whether the frames of `span` see through the surface that the stored frame `seen_in` shows of the label.
bool is_seen_through(const fields::PixelStore& pixels, const fields::StoredFrame& seen_in, int label,
                     const motion::Motion& motion, const motion::FrameSpan& span, std::size_t frames) {
  std::vector<const fields::StoredFrame*> stored;
  for (const fields::StoredFrame& frame : pixels.frames()) {
    const auto number = static_cast<std::size_t>(frame.frame);
    if (number >= span.begin && number < span.end) stored.push_back(&frame);
  }
  const auto tracks =
      motion::track_points(motion, frames, static_cast<std::size_t>(seen_in.frame), surface_in(pixels, seen_in, label));
  Looks looks;
  const std::size_t count = std::min(kFramesLookedAt, stored.size());
  for (std::size_t i = 0; i < count; ++i)
    look(pixels, *stored[count == 1 ? 0 : i * (stored.size() - 1) / (count - 1)], tracks, looks);
  return looks.told >= kMinTold && static_cast<double>(looks.through) >= kSeenThrough * static_cast<double>(looks.told);
}

bool is_tracked_in(const motion::Motion& motion, const motion::FrameSpan& span) {
  if (motion.kind() == motion::MotionKind::kStill) return false;
  for (std::size_t frame = span.begin; frame < span.end; ++frame) {
    if (motion.health(frame) == motion::Health::kTracked) return true;
  }
  return false;
}

} // namespace

motion::Presence layer_presence(const TrackedLabel& label, const motion::Motion& motion,
                                const fields::PixelStore& pixels, std::size_t frames) {
  const auto shows = [&](const fields::StoredFrame& frame) {
    return std::any_of(pixels.pixels().data() + frame.begin, pixels.pixels().data() + frame.end,
                       [&](const auto& pixel) { return pixel.label == label.plan.label && pixel.depth.is_measured(); });
  };
  const std::vector<fields::StoredFrame>& stored = pixels.frames();
  const auto first = std::find_if(stored.begin(), stored.end(), shows);
  if (first == stored.end()) return {};
  const auto last = std::find_if(stored.rbegin(), stored.rend(), shows);
  std::vector<motion::FrameSpan> away;
  const auto leave_out = [&](const motion::FrameSpan& span, const fields::StoredFrame& seen_in) {
    if (span.begin < span.end && !is_tracked_in(motion, span) &&
        is_seen_through(pixels, seen_in, label.plan.label, motion, span, frames))
      away.push_back(span);
  };
  leave_out({0, label.first_shown - std::min(kMargin, label.first_shown)}, *first);
  leave_out({label.last_shown + 1 + kMargin, frames}, *last);
  return motion::Presence::away_during(std::move(away));
}

} // namespace kinora::encode
