#include "encode/seen_points.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "core/sensor_noise.h"

namespace kinora::encode {
namespace {

constexpr std::size_t kPointsOfFrame = 2000;
constexpr int kLikeColor = 16; ///< of 255, mean over the channels

bool shows(const fields::StoredPixel& pixel, int label) { return pixel.label == label && pixel.depth.is_measured(); }

} // namespace

std::vector<const fields::StoredFrame*> frames_showing(const fields::PixelStore& pixels, int label) {
  std::vector<const fields::StoredFrame*> frames;
  for (const fields::StoredFrame& frame : pixels.frames()) {
    const auto* first = pixels.pixels().data() + frame.begin;
    const auto* last = pixels.pixels().data() + frame.end;
    if (std::any_of(first, last, [label](const auto& pixel) { return shows(pixel, label); })) frames.push_back(&frame);
  }
  return frames;
}

std::vector<SeenPoint> points_of(const fields::PixelStore& pixels, const fields::StoredFrame& frame, int label) {
  std::vector<SeenPoint> points;
  for (std::size_t i = frame.begin; i < frame.end; ++i) {
    const fields::StoredPixel& pixel = pixels.pixels()[i];
    if (!shows(pixel, label)) continue;
    points.push_back(
        {frame.camera.camera_to_world * frame.camera.intrinsics.unproject(pixel.u, pixel.v, pixel.depth.metres()),
         pixel.color});
  }
  const std::size_t step = 1 + points.size() / kPointsOfFrame;
  std::vector<SeenPoint> some;
  for (std::size_t i = 0; i < points.size(); i += step) some.push_back(points[i]);
  return some;
}

bool is_like(const Color& a, const Color& b) {
  int difference = 0;
  for (std::size_t c = 0; c < 3; ++c) difference += std::abs(static_cast<int>(a[c]) - static_cast<int>(b[c]));
  return difference <= 3 * kLikeColor;
}

StoredPicture::StoredPicture(const fields::PixelStore& pixels, const fields::StoredFrame& frame)
    : map_(pixels, frame), intrinsics_(frame.camera.intrinsics),
      world_to_camera_(frame.camera.camera_to_world.inverse()),
      kept_share_(static_cast<double>(frame.end - frame.begin) / static_cast<double>(map_.size())) {}

StoredPicture::Shown StoredPicture::at(const Eigen::Vector3d& world) const {
  Shown shown;
  const Eigen::Vector3d point = world_to_camera_ * world;
  if (!(point.z() > 0)) return shown;
  const Eigen::Vector2d place = intrinsics_.project(point).array().round();
  if (!(place.x() >= 0 && place.y() >= 0 && place.x() < intrinsics_.width && place.y() < intrinsics_.height)) {
    return shown;
  }
  const int u = static_cast<int>(place.x());
  const int v = static_cast<int>(place.y());
  shown.pixel = static_cast<std::int64_t>(map_.index(u, v));
  const fields::StoredPixel* pixel = map_.at(u, v);
  if (pixel == nullptr) {
    shown.look = Look::kNotKept;
    return shown;
  }
  const double tolerance = kThreeSigmaOfDifference * kSensorNoise.sigma(point.z());
  if (!pixel->depth.is_measured() || pixel->depth.metres() < point.z() - tolerance) return shown;
  shown.look = pixel->depth.metres() <= point.z() + tolerance ? Look::kThere : Look::kBehind;
  shown.color = pixel->color;
  return shown;
}

} // namespace kinora::encode
