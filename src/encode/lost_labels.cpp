#include "encode/lost_labels.h"

#include <algorithm>

#include <fmt/format.h>

#include "core/sensor_noise.h"

namespace kinora::encode {
namespace {

constexpr std::size_t kFramesCompared = 8;    ///< of those that show a label
constexpr std::size_t kPixelsCompared = 2000; ///< of a label, of each of these frames
constexpr double kStill = 0.5;
constexpr int kLikeColor = 16; ///< of 255, mean over the channels

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

using Color = std::array<std::uint8_t, 3>;

struct SeenPoint {
  Eigen::Vector3d world;
  Color color;
};

std::vector<SeenPoint> points_of(const fields::PixelStore& pixels, const fields::StoredFrame& frame, int label) {
  std::vector<SeenPoint> points;
  for (std::size_t i = frame.begin; i < frame.end; ++i) {
    const fields::StoredPixel& pixel = pixels.pixels()[i];
    if (!shows(pixel, label)) continue;
    points.push_back(
        {frame.camera.camera_to_world * frame.camera.intrinsics.unproject(pixel.u, pixel.v, pixel.depth.metres()),
         pixel.color});
  }
  const std::size_t step = 1 + points.size() / kPixelsCompared;
  std::vector<SeenPoint> some;
  for (std::size_t i = 0; i < points.size(); i += step) some.push_back(points[i]);
  return some;
}

bool is_like(const Color& a, const Color& b) {
  int difference = 0;
  for (std::size_t c = 0; c < 3; ++c) difference += std::abs(static_cast<int>(a[c]) - static_cast<int>(b[c]));
  return difference <= 3 * kLikeColor;
}

/// One stored frame as a picture: what is measured.
class SeenPicture {
public:
  SeenPicture(const fields::PixelStore& pixels, const fields::StoredFrame& frame)
      : camera_(frame.camera), world_to_camera_(frame.camera.camera_to_world.inverse()),
        depth_(frame.camera.intrinsics.width, frame.camera.intrinsics.height), colors_(depth_.pixel_count()) {
    for (std::size_t i = frame.begin; i < frame.end; ++i) {
      const fields::StoredPixel& pixel = pixels.pixels()[i];
      if (!pixel.depth.is_measured()) continue;
      depth_.at(pixel.u, pixel.v) = pixel.depth.metres();
      colors_[at(pixel.u, pixel.v)] = pixel.color;
    }
  }

  /// Whether the picture shows the point, or the like; nullopt: it is outside, nothing is measured there, or something
  /// stands before it.
  std::optional<bool> shows_again(const SeenPoint& seen) const {
    const Eigen::Vector3d point = world_to_camera_ * seen.world;
    if (point.z() <= 0) return std::nullopt;
    const Eigen::Vector2d pixel = camera_.intrinsics.project(point);
    const double x = std::round(pixel.x());
    const double y = std::round(pixel.y());
    if (!(x >= 0 && y >= 0 && x < depth_.width() && y < depth_.height())) return std::nullopt;
    const int u = static_cast<int>(x);
    const int v = static_cast<int>(y);
    const double z = depth_.at(u, v);
    const double tolerance = kThreeSigmaOfDifference * kSensorNoise.sigma(point.z());
    if (z <= 0 || z < point.z() - tolerance) return std::nullopt;
    return z <= point.z() + tolerance || is_like(colors_[at(u, v)], seen.color);
  }

private:
  std::size_t at(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(depth_.width()) + static_cast<std::size_t>(u);
  }

  Camera camera_;
  SE3 world_to_camera_;
  DepthImage depth_;
  std::vector<Color> colors_;
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
  std::size_t told = 0;
  std::size_t still = 0;
  for (const fields::StoredFrame* seen_in : compared) {
    const SeenPicture picture(pixels, *seen_in);
    for (const fields::StoredFrame* frame : compared) {
      if (frame == seen_in) continue;
      for (const SeenPoint& point : points_of(pixels, *frame, label)) {
        const std::optional<bool> again = picture.shows_again(point);
        told += again ? 1 : 0;
        still += again.value_or(false) ? 1 : 0;
      }
    }
  }
  return told == 0 ? 0 : static_cast<double>(still) / static_cast<double>(told);
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
         fmt::format("it is lost in most frames that show it, and other frames show {:.0f} % of it where it is: {}",
                     100 * still, joins_room ? "the background has it" : "nothing is made of it")});
    if (joins_room) pass.pixels.relabel(number, 0);
    it = pass.labels.erase(it);
  }
  return dropped;
}

} // namespace kinora::encode
