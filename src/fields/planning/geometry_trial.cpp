#include "fields/planning/geometry_trial.h"

#include <algorithm>
#include <cmath>

#include "fields/rendering/renderer.h"
#include "fields/sampling/surface_band.h"

namespace kinora::fields {
namespace {

constexpr std::size_t kValidationFrames = 3;
constexpr std::size_t kTrialPixels = 1'000'000; // of all layers, that a trial trains on
constexpr double kShareOfRays = 1.0 / 40;       // of a whole training, for each geometry
constexpr std::size_t kMinRays = 250'000;

/// Frames in which the layer is seen and its place is known.
std::vector<std::size_t> usable_frames(const LayerObservations& layer) {
  const PixelStore& pixels = layer.pixels;
  std::vector<std::size_t> usable;
  for (std::size_t f = 0; f < pixels.frames().size(); ++f) {
    const StoredFrame& frame = pixels.frames()[f];
    const auto first = pixels.pixels().begin() + static_cast<std::ptrdiff_t>(frame.begin);
    const auto end = pixels.pixels().begin() + static_cast<std::ptrdiff_t>(frame.end);
    const auto is_measured_foreground = [&layer](const StoredPixel& pixel) {
      return layer.is_foreground(pixel) && pixel.depth.is_measured();
    };
    if (!layer.is_lost(frame) && std::any_of(first, end, is_measured_foreground)) usable.push_back(f);
  }
  return usable;
}

/// Frames to be left out: spread over the clip, and not its ends, which have neighbours on one side alone.
std::vector<std::size_t> choose_validation_frames(const std::vector<std::size_t>& usable) {
  std::vector<std::size_t> validation_frames;
  if (usable.size() < 2 * kValidationFrames) return validation_frames;
  for (std::size_t i = 0; i < kValidationFrames; ++i) {
    validation_frames.push_back(usable[(2 * i + 1) * usable.size() / (2 * kValidationFrames)]);
  }
  return validation_frames;
}

/// What a field of the layer draws for one frame, against the frame's pixels.
class Validation {
public:
  explicit Validation(const LayerObservations& layer) : layer_(layer) {}

  DrawingError evaluate(const Field& field, const std::vector<std::size_t>& frames) {
    const DrawableField drawable(field, layer_.motion.graph().get());
    for (const std::size_t f : frames) {
      const StoredFrame& frame = layer_.pixels.frames()[f];
      const PosedField posed = pose(drawable, layer_.motion.warp(frame.frame));
      const Picture picture = render({&posed, 1}, frame.camera);
      for (std::size_t i = frame.begin; i < frame.end; ++i) compare(picture, layer_.pixels.pixels()[i]);
    }
    const auto middle = depths_.begin() + static_cast<std::ptrdiff_t>(depths_.size() / 2);
    std::nth_element(depths_.begin(), middle, depths_.end());
    return {std::sqrt(squares_ / static_cast<double>(3 * std::max<std::size_t>(foreground_pixels_, 1))),
            depths_.empty() ? 0 : static_cast<double>(*middle)};
  }

private:
  void compare(const Picture& picture, const StoredPixel& pixel) {
    const std::uint8_t* drawn = picture.color.pixel(pixel.u, pixel.v);
    const double opacity = drawn[3] / 255.0;
    const bool foreground = layer_.is_foreground(pixel);
    if (foreground && !pixel.depth.is_known()) return; // nothing tells whether there is anything to be drawn
    const float depth = picture.depth.at(pixel.u, pixel.v);
    if (!foreground && depth >= free_space_until(pixel)) return; // it may well be there, behind what the pixel shows
    for (std::size_t c = 0; c < 3; ++c) {
      const double difference = opacity * drawn[c] - (foreground ? pixel.color[c] : 0);
      squares_ += difference * difference;
    }
    if (foreground) ++foreground_pixels_;
    if (foreground && pixel.depth.is_measured()) depths_.push_back(std::abs(depth - pixel.depth.metres()));
  }

  LayerObservations layer_;
  double squares_ = 0;
  std::size_t foreground_pixels_ = 0;
  std::vector<float> depths_;
};

} // namespace

Geometry better_geometry(const DrawingError& density, const DrawingError& signed_distance) {
  constexpr double kEqualErrors = 0.003;
  const double difference = signed_distance.color - density.color;
  const bool alike = std::abs(difference) < kEqualErrors * density.color;
  const bool better = alike ? signed_distance.depth < density.depth : difference < 0;
  return better ? Geometry::kSignedDistance : Geometry::kDensity;
}

GeometryTrial try_geometries(const LayerObservations& layer, const FieldConfig& config, const TrainerConfig& trainer,
                             Progress& progress) {
  GeometryTrial trial;
  const std::vector<std::size_t> validation_frames = choose_validation_frames(usable_frames(layer));
  trial.frames = validation_frames.size();
  if (validation_frames.empty()) return trial;
  const PixelStore part = layer.pixels.thinned(validation_frames, kTrialPixels);
  TrainerConfig shorter = trainer;
  shorter.quantisation = {};
  shorter.exchange.decibels_per_second /= kShareOfRays;
  shorter.rays = std::max(kMinRays, static_cast<std::size_t>(kShareOfRays * static_cast<double>(trainer.rays)));
  for (auto [geometry, error] :
       {std::pair(Geometry::kDensity, &trial.density), std::pair(Geometry::kSignedDistance, &trial.signed_distance)}) {
    FieldConfig tried = config;
    tried.geometry = geometry;
    TrainingReport report;
    const Field field = train_field({part, layer.label, layer.motion}, tried, shorter, progress, &report);
    trial.rays += report.rays;
    *error = Validation(layer).evaluate(field, validation_frames);
  }
  trial.chosen = better_geometry(trial.density, trial.signed_distance);
  return trial;
}

} // namespace kinora::fields
