#include "encode/unfounded_labels.h"

#include <algorithm>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "encode/seen_points.h"
#include "motion/point_track.h"

namespace kinora::encode {
namespace {

using Look = StoredPicture::Look;

constexpr std::size_t kFramesCompared = 8; ///< of those that show a label
constexpr double kStill = 0.5;
constexpr double kMinGain = 0.005;    ///< of all looks, found by motion alone
constexpr double kMostLeft = 0.8;     ///< unexplained by motion, of what rest leaves unexplained
constexpr double kOverRoom = 2;       ///< unexplained by rest, of what rest leaves unexplained of the room
constexpr double kRestExplains = 0.5; ///< of what is told; below, the room is no explanation

std::vector<std::size_t> spread_over(std::size_t count) {
  const std::size_t chosen = std::min(kFramesCompared, count);
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < chosen; ++i) places.push_back(chosen == 1 ? 0 : i * (count - 1) / (chosen - 1));
  return places;
}

bool shows_itself(const StoredPicture::Shown& shown, const SeenPoint& seen) {
  return shown.look == Look::kThere && is_like(shown.color, seen.color);
}

/// Whether a frame shows again what another saw there, or the like; nullopt: it does not tell.
std::optional<bool> shows_again(const StoredPicture& picture, const SeenPoint& seen) {
  const StoredPicture::Shown shown = picture.at(seen.world);
  if (shown.look == Look::kThere) return true;
  if (shown.look == Look::kBehind) return is_like(shown.color, seen.color);
  return std::nullopt;
}

bool is_lost(const motion::Motion& motion, const fields::StoredFrame& frame) {
  return motion.health(static_cast<std::size_t>(frame.frame)) == motion::Health::kLost;
}

bool is_from_segmenter(int label, const ingest::CaptureInfo& capture) {
  const auto found = capture.labels.find(label);
  return found != capture.labels.end() && !found->second.why.empty();
}

/// Why no layer is made of a label; empty: one is.
std::string what_speaks_against(const FramePass& pass, int number, const TrackedLabel& label) {
  const motion::Motion motion = label.motion();
  if (motion.kind() == motion::MotionKind::kStill) return {};
  const std::vector<const fields::StoredFrame*> shown = frames_showing(pass.pixels, number);
  const auto followed = static_cast<std::size_t>(std::count_if(shown.begin(), shown.end(), [&](const auto* frame) {
    return motion.health(static_cast<std::size_t>(frame->frame)) == motion::Health::kTracked;
  }));
  if (2 * followed < shown.size()) return "it is followed in fewer than half of the frames that show it";
  if (!motion_gain(pass.pixels, number, motion, pass.clip.times.size()).pays()) {
    return "its motion explains the frames no better than if it kept still";
  }
  return {};
}

} // namespace

double still_share(const fields::PixelStore& pixels, int label) {
  const std::vector<const fields::StoredFrame*> shown = frames_showing(pixels, label);
  const std::vector<std::size_t> compared = spread_over(shown.size());
  std::size_t told = 0;
  std::size_t still = 0;
  for (const std::size_t to : compared) {
    const StoredPicture picture(pixels, *shown[to]);
    for (const std::size_t from : compared) {
      if (from == to) continue;
      for (const SeenPoint& point : points_of(pixels, *shown[from], label)) {
        const std::optional<bool> again = shows_again(picture, point);
        told += again ? 1 : 0;
        still += again.value_or(false) ? 1 : 0;
      }
    }
  }
  return told == 0 ? 0 : static_cast<double>(still) / static_cast<double>(told);
}

bool MotionGain::pays() const {
  if (at_rest < kRestExplains * told || told == 0) return true;
  const double as_if_room_moved = room_told > 0 ? told * (room_told - room_at_rest) / room_told : 0;
  if (told - at_rest < kOverRoom * as_if_room_moved) return false;
  return by_motion - at_rest >= kMinGain * looks && told - by_motion <= kMostLeft * (told - at_rest);
}

MotionGain motion_gain(const fields::PixelStore& pixels, int label, const motion::Motion& motion, std::size_t frames) {
  std::vector<const fields::StoredFrame*> followed = frames_showing(pixels, label);
  std::erase_if(followed, [&](const auto* frame) { return is_lost(motion, *frame); });
  MotionGain gain;
  for (const std::size_t from : spread_over(followed.size())) {
    const std::vector<SeenPoint> points = points_of(pixels, *followed[from], label);
    std::vector<Eigen::Vector3d> places;
    places.reserve(points.size());
    for (const SeenPoint& point : points) places.push_back(point.world);
    const auto tracks = motion::track_points(motion, frames, static_cast<std::size_t>(followed[from]->frame), places);
    const SE3& from_camera = followed[from]->camera.camera_to_world;
    const std::vector<SeenPoint> room = points_of(pixels, *followed[from], 0);
    const auto look = [&](const fields::StoredFrame& frame) {
      const StoredPicture picture(pixels, frame);
      for (const SeenPoint& point : room) {
        if (frame.camera.camera_to_world.matrix() == from_camera.matrix()) break;
        const StoredPicture::Shown shown = picture.at(point.world);
        if (shown.look == Look::kNotKept || shown.look == Look::kNothing) continue;
        ++gain.room_told;
        gain.room_at_rest += shows_itself(shown, point) ? 1 : 0;
      }
      for (std::size_t i = 0; i < points.size(); ++i) {
        const StoredPicture::Shown rest = picture.at(places[i]);
        const StoredPicture::Shown moved = picture.at(tracks[i][static_cast<std::size_t>(frame.frame)]);
        if (rest.look == Look::kNotKept || moved.look == Look::kNotKept) continue;
        double weight = rest.pixel >= 0 ? 1 / picture.kept_share() : 1;
        if (moved.pixel >= 0 && moved.pixel != rest.pixel) weight /= picture.kept_share();
        gain.looks += weight;
        if (rest.look == Look::kNothing || moved.look == Look::kNothing) continue;
        gain.told += weight;
        if (shows_itself(rest, points[i])) gain.at_rest += weight;
        if (shows_itself(moved, points[i])) gain.by_motion += weight;
      }
    };
    for (std::size_t away = 1; away < followed.size(); away *= 2) {
      if (away <= from) look(*followed[from - away]);
      if (from + away < followed.size()) look(*followed[from + away]);
    }
  }
  return gain;
}

std::vector<NotModelled> drop_unfounded_labels(FramePass& pass, const ingest::CaptureInfo& capture) {
  std::vector<NotModelled> dropped;
  for (auto it = pass.labels.begin(); it != pass.labels.end();) {
    const auto& [number, label] = *it;
    const std::string why =
        number != 0 && is_from_segmenter(number, capture) ? what_speaks_against(pass, number, label) : std::string();
    if (why.empty()) {
      ++it;
      continue;
    }
    const double still = still_share(pass.pixels, number);
    const bool joins_room = still >= kStill && pass.labels.contains(0);
    dropped.push_back({label.plan.name, number,
                       fmt::format("{}, and other frames show {:.0f} % of it where it is: {}", why, 100 * still,
                                   joins_room ? "the background has it" : "nothing is made of it")});
    if (joins_room) pass.pixels.relabel(number, 0);
    it = pass.labels.erase(it);
  }
  return dropped;
}

} // namespace kinora::encode
