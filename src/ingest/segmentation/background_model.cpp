#include "ingest/segmentation/background_model.h"

#include "core/parallel.h"
#include "ingest/images/picture_change.h"

namespace kinora::ingest {
namespace {

constexpr float kNever = std::numeric_limits<float>::infinity();
constexpr std::size_t kPixelsPerChunk = 2048;
constexpr double kMinSupport = 0.08;       ///< of all samples must see the stable depth
constexpr double kMinUnmeasured = 0.2;     ///< of all samples: nothing is measured where the background is out of range
constexpr double kNear = 0.15;             ///< metres: a surface that wavers, not another one in front
constexpr double kMaxUnstableShare = 0.15; ///< share of measurements of a still surface that may be off it
constexpr std::size_t kMinMeasurements = 24; ///< measurements to judge a surface by
constexpr double kMinBody = 0.45;            ///< metres: what moves by itself and is smaller is a part of a body
constexpr double kMaxBody = 2.2;
constexpr double kMinArea = 0.004;     ///< square metres: less is noise …
constexpr std::size_t kMinPixels = 60; ///< … and so are fewer pixels

/// Counts a pixel of a sample for what the pictures say: its colour is not the one that is seen there while all keeps
/// still (nullptr: not known), or, of few samples, another one's.
void find_change(std::span<const ReducedView> samples, const ReducedView& sample, int u, int v,
                 const std::uint8_t* still, PictureChange& picture) {
  const bool few = samples.size() < kFewSamples;
  if ((!few && still == nullptr) || !has_texture(sample.color, u, v)) return;
  const auto differs_from = [&](const std::uint8_t* color) {
    return difference(sample.color.pixel(u, v), color) > kColorChange;
  };
  picture.add(few ? std::any_of(samples.begin(), samples.end(),
                                [&](const ReducedView& other) { return differs_from(other.color.pixel(u, v)); })
                  : differs_from(still));
}

/// Where something is in a picture, and what colour it has there while it keeps still.
struct StillPixel {
  int u, v;
  double z;                  ///< metres
  const std::uint8_t* color; ///< nullptr: not known
};

/// How often a surface is measured where it is, and how often close to it but not there.
struct TemporalVariance {
  std::size_t on = 0;
  std::size_t off = 0;
  PictureChange picture; ///< where it is off

  /// Counts the samples' measurements at a pixel. What is found within `slack` pixels is there.
  void add(std::span<const ReducedView> samples, const StillPixel& pixel, int slack) {
    const auto& [u, v, z, color] = pixel;
    const double tolerance = 1.5 * same_surface_tolerance(z);
    for (const ReducedView& sample : samples) {
      const double seen = sample.depth.at(u, v);
      if (seen <= 0 || seen < z - kNear || seen > z + kNear) continue;
      bool there = std::abs(seen - z) <= tolerance;
      for (int y = std::max(0, v - slack); y <= std::min(sample.depth.height() - 1, v + slack) && !there; ++y)
        for (int x = std::max(0, u - slack); x <= std::min(sample.depth.width() - 1, u + slack) && !there; ++x)
          there = std::abs(sample.depth.at(x, y) - z) <= tolerance;
      ++(there ? on : off);
      if (!there) find_change(samples, sample, u, v, color, picture);
    }
  }
  /// A sensor's far depth may waver more than tolerances allow: texture that stays where it is denies that it moves.
  bool moves() const {
    return on + off >= kMinMeasurements &&
           static_cast<double>(off) > kMaxUnstableShare * static_cast<double>(on + off) && !picture.denies();
  }
};

std::uint8_t median_of(std::vector<std::uint8_t>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Channel-wise median colour at pixel i of the samples that `use` accepts; false if there are none.
template <class Use>
bool median_color(std::span<const ReducedView> samples, std::size_t i, const Use& use, std::uint8_t* result) {
  std::vector<std::uint8_t> channels[3];
  for (const ReducedView& sample : samples) {
    if (!use(sample.depth.data()[i])) continue;
    for (std::size_t c = 0; c < 3; ++c) channels[c].push_back(sample.color.data()[3 * i + c]);
  }
  if (channels[0].empty()) return false;
  for (std::size_t c = 0; c < 3; ++c) result[c] = median_of(channels[c]);
  return true;
}

/// How many of the views that saw a pixel must agree on its depth; of few, one is enough.
std::size_t support_among(std::size_t count) {
  if (count < kFewSamples) return 1;
  return std::max<std::size_t>(3, static_cast<std::size_t>(kMinSupport * static_cast<double>(count)));
}

/// Median of the farthest window of sorted depths that holds `support` of them; 0 if there is none.
float farthest_stable(const std::vector<float>& sorted, std::size_t support) {
  for (std::size_t last = sorted.size(); last-- > 0;) {
    const double window = 2 * same_surface_tolerance(sorted[last]);
    std::size_t first = last;
    while (first > 0 && sorted[last] - sorted[first - 1] <= window) --first;
    if (last - first + 1 >= support) return sorted[first + (last - first) / 2];
  }
  return 0;
}

} // namespace

BackgroundModel::BackgroundModel(std::span<const ReducedView> samples, int slack)
    : slack_(slack), intrinsics_(samples.front().intrinsics), depth_(intrinsics_.width, intrinsics_.height),
      color_(intrinsics_.width, intrinsics_.height, 3), has_color_(intrinsics_.width, intrinsics_.height),
      known_(intrinsics_.width, intrinsics_.height), measured_(intrinsics_.width, intrinsics_.height) {
  find_farthest_stable(samples);
  find_colors(samples);
  planes_ = find_planes(depth_, intrinsics_);
  drop_high_variance_planes(samples);
  drop_high_variance(samples);
  drop_connected_to_foreground(samples);
}

void BackgroundModel::find_farthest_stable(std::span<const ReducedView> samples) {
  parallel_for(depth_.pixel_count(), kPixelsPerChunk, [&](const Chunk& pixels) {
    std::vector<float> measured;
    for (std::size_t i = pixels.begin; i < pixels.end; ++i) {
      measured.clear();
      std::size_t count = 0;
      for (const ReducedView& sample : samples) {
        const float z = sample.depth.data()[i];
        count += z != kUnseen ? 1 : 0;
        if (z > 0) measured.push_back(z);
      }
      measured_.data()[i] = measured.empty() ? 0 : 1;
      if (count < std::min(samples.size(), kFewSamples)) continue;
      known_.data()[i] = 1;
      std::sort(measured.begin(), measured.end());
      depth_.data()[i] = farthest_stable(measured, support_among(count));
      const auto unmeasured = static_cast<double>(count - measured.size());
      if (unmeasured < std::max(1.0, kMinUnmeasured * static_cast<double>(count))) continue;
      // Holes of one surface look like it; where something stands before a background out of range, they do not.
      std::uint8_t hole[3];
      std::uint8_t surface[3];
      (void)median_color(
          samples, i, [](float z) { return z == 0; }, hole);
      const bool seen = median_color(
          samples, i, [](float z) { return z > 0; }, surface);
      if (!seen || difference(hole, surface) > kColorChange) depth_.data()[i] = kNever;
    }
  });
}

SurfaceComponents BackgroundModel::surfaces_off_planes() const {
  Mask mask(depth_.width(), depth_.height());
  DepthImage finite = depth_;
  for (float& z : finite.values())
    if (z == kNever) z = 0;
  for (int v = 0; v < mask.height(); ++v)
    for (int u = 0; u < mask.width(); ++u)
      if (const float z = finite.at(u, v); z > 0) mask.at(u, v) = on_plane(intrinsics_.unproject(u, v, z)) ? 0 : 1;
  return surface_components(finite, mask, intrinsics_);
}

/// A plane that fits a person's front moves with it.
void BackgroundModel::drop_high_variance_planes(std::span<const ReducedView> samples) {
  std::vector<TemporalVariance> temporal_variance(planes_.size());
  for (int v = 0; v < depth_.height(); ++v) {
    for (int u = 0; u < depth_.width(); ++u) {
      const float z = depth_.at(u, v);
      if (!(z > 0) || z == kNever) continue;
      const Eigen::Vector3d point = intrinsics_.unproject(u, v, z);
      for (std::size_t i = 0; i < planes_.size(); ++i)
        if (std::abs(planes_[i].distance(point)) <= same_surface_tolerance(z))
          temporal_variance[i].add(samples, {u, v, z, still_color(u, v)}, slack_);
    }
  }
  std::vector<Plane> still;
  for (std::size_t i = 0; i < planes_.size(); ++i)
    if (!temporal_variance[i].moves()) still.push_back(planes_[i]);
  planes_ = std::move(still);
}

/// A still surface is measured where it is, or hidden by something clearly in front of it.
void BackgroundModel::drop_high_variance(std::span<const ReducedView> samples) {
  const SurfaceComponents surfaces = surfaces_off_planes();
  std::vector<TemporalVariance> temporal_variance(surfaces.list.size());
  for (int v = 1; v + 1 < depth_.height(); ++v) {
    for (int u = 1; u + 1 < depth_.width(); ++u) {
      const std::int32_t number = surfaces.map.at(u, v);
      const bool inside = number >= 0 && surfaces.map.at(u - 1, v) == number && surfaces.map.at(u + 1, v) == number &&
                          surfaces.map.at(u, v - 1) == number && surfaces.map.at(u, v + 1) == number;
      if (!inside) continue;
      temporal_variance[static_cast<std::size_t>(number)].add(samples, {u, v, depth_.at(u, v), still_color(u, v)},
                                                              slack_);
    }
  }
  std::size_t known = 0;
  std::size_t still = 0;
  for (std::size_t i = 0; i < depth_.pixel_count(); ++i) {
    if (depth_.data()[i] <= 0) continue;
    ++known;
    const std::int32_t number = surfaces.map.data()[i];
    if (number >= 0 && temporal_variance[static_cast<std::size_t>(number)].moves())
      depth_.data()[i] = 0;
    else
      ++still;
  }
  static_share_ = known == 0 ? 0 : static_cast<double>(still) / static_cast<double>(known);
}

/// What is still but hangs on something that moves belongs to it: the trunk of somebody who moves the head alone, or
/// what is left of a body between two places. The moving thing is then too small to be whole, or the still one hangs
/// on nothing else.
void BackgroundModel::drop_connected_to_foreground(std::span<const ReducedView> samples) {
  const SurfaceComponents surfaces = surfaces_off_planes();
  struct Contacts {
    std::size_t to_part = 0;       ///< to something that moves and is too small to be a body
    std::size_t to_foreground = 0; ///< to anything that moves
    std::size_t to_ground = 0;     ///< to another still surface
  };
  std::vector<Contacts> contacts(surfaces.list.size());
  for (const ReducedView& sample : samples) {
    const Image<Ground> ground = ground_of(sample);
    Mask moving(ground.width(), ground.height());
    for (std::size_t i = 0; i < moving.pixel_count(); ++i) moving.data()[i] = ground.data()[i] == Ground::kForeground;
    const SurfaceComponents parts = surface_components(sample.depth, moving, intrinsics_);
    std::vector<PictureChange> pictures(parts.list.size());
    for (int v = 0; v < parts.map.height(); ++v)
      for (int u = 0; u < parts.map.width(); ++u)
        if (const std::int32_t number = parts.map.at(u, v); number >= 0)
          find_change(samples, sample, u, v, still_color(u, v), pictures[static_cast<std::size_t>(number)]);
    const auto touch = [&](int u, int v, int x, int y) {
      const std::int32_t number = surfaces.map.at(u, v);
      if (number < 0 || ground.at(u, v) != Ground::kBackground || ground.at(x, y) == Ground::kUnmeasured ||
          ground.at(x, y) == Ground::kUnknown)
        return;
      const float a = sample.depth.at(u, v);
      const float b = sample.depth.at(x, y);
      if (std::abs(a - b) > 2 * same_surface_tolerance(a) || surfaces.map.at(x, y) == number) {
        if (ground.at(x, y) == Ground::kBackground || std::abs(a - b) > 2 * same_surface_tolerance(a)) return;
      }
      Contacts& contact = contacts[static_cast<std::size_t>(number)];
      if (ground.at(x, y) == Ground::kBackground) {
        ++contact.to_ground;
        return;
      }
      const auto number_of_part = static_cast<std::size_t>(parts.map.at(x, y));
      const SurfaceComponent& part = parts.list[number_of_part];
      if (part.area < kMinArea || part.pixels < kMinPixels || pictures[number_of_part].denies()) return;
      ++contact.to_foreground;
      if (part.extent() < kMinBody) ++contact.to_part;
    };
    for (int v = 0; v + 1 < ground.height(); ++v) {
      for (int u = 0; u + 1 < ground.width(); ++u) {
        touch(u, v, u + 1, v);
        touch(u + 1, v, u, v);
        touch(u, v, u, v + 1);
        touch(u, v + 1, u, v);
      }
    }
  }
  for (std::size_t i = 0; i < depth_.pixel_count(); ++i) {
    const std::int32_t number = surfaces.map.data()[i];
    if (number < 0) continue;
    const Contacts& contact = contacts[static_cast<std::size_t>(number)];
    const SurfaceComponent& surface = surfaces.list[static_cast<std::size_t>(number)];
    const bool enough = contact.to_foreground >= 3 * samples.size();
    const std::size_t ground_weight = samples.size() < kFewSamples ? 1 : 3;
    const bool left_over = enough && contact.to_foreground > ground_weight * contact.to_ground;
    const bool trunk = enough && 2 * contact.to_part > 3 * contact.to_ground &&
                       2 * contact.to_part > contact.to_foreground && surface.extent() < kMaxBody;
    if (left_over || trunk) depth_.data()[i] = 0;
  }
}

void BackgroundModel::find_colors(std::span<const ReducedView> samples) {
  parallel_for(depth_.pixel_count(), kPixelsPerChunk, [&](const Chunk& pixels) {
    for (std::size_t i = pixels.begin; i < pixels.end; ++i) {
      const float z = depth_.data()[i];
      if (z <= 0) continue;
      const double tolerance = z == kNever ? 0 : 1.5 * same_surface_tolerance(z);
      const auto is_background = [&](float seen) {
        return z == kNever ? seen == 0 : seen > 0 && seen >= z - tolerance;
      };
      if (median_color(samples, i, is_background, &color_.data()[3 * i])) has_color_.data()[i] = 1;
    }
  });
}

bool BackgroundModel::on_plane(const Eigen::Vector3d& point) const {
  return std::any_of(planes_.begin(), planes_.end(), [&](const Plane& plane) {
    return plane.distance(point) <= 1.2 * same_surface_tolerance(point.z()) &&
           plane.distance(point) >= -3 * same_surface_tolerance(point.z());
  });
}

/// The least depth within `reach` pixels of one that has a depth.
float BackgroundModel::nearest_within(int u, int v, int reach) const {
  float nearest = depth_.at(u, v);
  if (reach == 0 || nearest == 0) return nearest;
  for (int y = std::max(0, v - reach); y <= std::min(depth_.height() - 1, v + reach); ++y)
    for (int x = std::max(0, u - reach); x <= std::min(depth_.width() - 1, u + reach); ++x)
      if (const float z = depth_.at(x, y); z > 0) nearest = std::min(nearest, z);
  return nearest;
}

bool BackgroundModel::in_front(int u, int v, const Eigen::Vector3d& point, int reach) const {
  const float behind = nearest_within(u, v, reach);
  return !(behind > 0 && behind < kNever && point.z() > behind - 1.3 * same_surface_tolerance(behind));
}

Ground BackgroundModel::ground_of(int u, int v, const Eigen::Vector3d& point) const {
  if (!(point.z() > 0)) return Ground::kUnmeasured;
  if (known_.at(u, v) == 0) return Ground::kUnknown;
  return in_front(u, v, point, slack_) && !on_plane(point) ? Ground::kForeground : Ground::kBackground;
}

bool BackgroundModel::is_clear_foreground(int u, int v, const Eigen::Vector3d& point) const {
  return slack_ == 0 || in_front(u, v, point, 2 * slack_ + 1);
}

bool BackgroundModel::is_on_background(int u, int v, const Eigen::Vector3d& point) const {
  const double z = depth_.at(u, v);
  return z > 0 && std::abs(point.z() - z) <= 1.3 * same_surface_tolerance(z);
}

Image<Ground> BackgroundModel::ground_of(const ReducedView& view) const {
  Image<Ground> ground(view.depth.width(), view.depth.height());
  for (int v = 0; v < ground.height(); ++v)
    for (int u = 0; u < ground.width(); ++u)
      ground.at(u, v) = ground_of(u, v, view.intrinsics.unproject(u, v, view.depth.at(u, v)));
  return ground;
}

const std::uint8_t* BackgroundModel::still_color(int u, int v) const {
  return depth_.at(u, v) > 0 && has_color_.at(u, v) != 0 ? color_.pixel(u, v) : nullptr;
}

std::optional<int> BackgroundModel::color_difference(int u, int v, const std::uint8_t* color) const {
  const std::uint8_t* still = still_color(u, v);
  if (still == nullptr) return std::nullopt;
  return difference(still, color);
}

} // namespace kinora::ingest
