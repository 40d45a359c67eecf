#include "fields/renderer.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/parallel.h"
#include "fields/field_batch.h"
#include "fields/occupancy.h"
#include "fields/ray_batch.h"

namespace kinora::fields {

struct DrawableField::Derived {
  Field field;
  std::vector<GridLevel> levels;
  DistanceField distances;
};

DrawableField::DrawableField(Field field) {
  auto derived = std::make_shared<Derived>();
  derived->levels = grid_levels(field.config);
  derived->distances = DistanceField(field.occupancy);
  derived->field = std::move(field);
  derived_ = std::move(derived);
}
const Field& DrawableField::field() const { return derived_->field; }

PosedField pose(const DrawableField& field, const tracking::Warp& warp) {
  if (warp.is_rigid()) return {&field, warp.rigid(), nullptr};
  return {&field, SE3::Identity(),
          std::make_shared<const LiveSpace>(field.field().config, field.field().occupancy, warp)};
}

namespace {

constexpr int kTile = 16;           // pixels per side
constexpr float kNearDepth = 0.02F; // metres
constexpr float kFarDepth = 1e6F;   // metres
constexpr float kOpaque = 0.004F;   // transmittance at which a ray ends
constexpr int kSamplesPerRound = 4; // of each ray between two looks at its transmittance
constexpr std::size_t kG = FieldConfig::kGeometry;

/// A layer's camera, relative to the box that its rays walk through: the layer's own, or of its live space.
struct LayerView {
  const DrawableField::Derived* layer;
  const LiveSpace* live; ///< nullptr unless the layer deforms
  const DistanceField* distances;
  Eigen::Vector3f origin;
  Eigen::Matrix3f rotation;
  float step; // metres between samples
};

struct ShadedSample {
  float depth;
  float optical_depth; // density × length
  std::uint32_t ray;   // pixel of the tile
  std::array<float, kG - 1> features;
};

/// One layer in one tile: the samples of every pixel's ray, near to far, until the layer alone is opaque.
class LayerTile {
public:
  void march(const LayerView& view, const Intrinsics& intrinsics, int left, int top, int width, int height);
  /// Per pixel of the tile, row by row: its samples in order of depth.
  const std::vector<std::vector<ShadedSample>>& rays() const { return rays_; }

private:
  struct ActiveRay {
    std::uint32_t pixel;
    FieldRay ray;
    OccupiedIntervals walk;
    Interval interval{0, 0};
    float depth = 0; // of the next sample
    float step = 0;  // in depth
    float transmittance = 1;
  };
  struct Pending {
    std::uint32_t active;
    float depth;
  };

  static bool advance(ActiveRay& ray);
  void collect(const LayerView& view, std::uint32_t active);
  void shade(const LayerView& view);

  std::vector<ActiveRay> active_;
  std::vector<std::vector<ShadedSample>> rays_;
  std::vector<Pending> pending_;
  std::vector<float> x_, y_, z_;
  PointBatch points_;
};

// Moves to the next sample point inside an occupied interval; samples lie on a fixed ladder of depths.
bool LayerTile::advance(ActiveRay& ray) {
  while (ray.depth >= ray.interval.end) {
    if (!ray.walk.next(ray.interval)) return false;
    const float rung = std::ceil(ray.interval.begin / ray.step - 0.5F);
    ray.depth = std::max(ray.depth, (rung + 0.5F) * ray.step);
  }
  return true;
}

// Notes the ray's next sample, unless canonical space is empty there.
void LayerTile::collect(const LayerView& view, std::uint32_t active) {
  ActiveRay& ray = active_[active];
  const float depth = ray.depth;
  ray.depth += ray.step;
  std::array<float, 3> position{};
  for (std::size_t a = 0; a < 3; ++a) position[a] = ray.ray.origin[a] + depth * ray.ray.direction[a];
  if (view.live != nullptr) {
    const LiveSpace::Map* map = view.live->map_at(position);
    if (map == nullptr) return;
    position = map->apply(position);
    if (!is_occupied(view.layer->field.occupancy, position)) return;
  }
  pending_.push_back({active, depth});
  x_.push_back(position[0]);
  y_.push_back(position[1]);
  z_.push_back(position[2]);
}

void LayerTile::shade(const LayerView& view) {
  const std::size_t n = pending_.size();
  evaluate_points(view.layer->field, view.layer->levels, {x_.data(), y_.data(), z_.data(), n}, points_);
  const float unit = 1.0F / static_cast<float>(view.layer->field.config.density_length());
  for (std::size_t i = 0; i < n; ++i) {
    ActiveRay& ray = active_[pending_[i].active];
    const float* g = points_.geometry.data() + i * kG;
    ShadedSample sample{};
    sample.depth = pending_[i].depth;
    sample.ray = ray.pixel;
    sample.optical_depth = std::exp(std::min(g[0], kMaxRawDensity)) * ray.step * ray.ray.metres_per_depth * unit;
    std::copy_n(g + 1, kG - 1, sample.features.begin());
    if (ray.transmittance > kOpaque) rays_[ray.pixel].push_back(sample);
    ray.transmittance *= std::exp(-sample.optical_depth);
  }
}

void LayerTile::march(const LayerView& view, const Intrinsics& intrinsics, int left, int top, int width, int height) {
  active_.clear();
  rays_.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (auto& samples : rays_) samples.clear();
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const Eigen::Vector3f pixel_ray = intrinsics.unproject(left + u, top + v, 1.0).cast<float>();
      const Eigen::Vector3f direction = view.rotation * pixel_ray;
      ActiveRay ray{};
      ray.pixel = static_cast<std::uint32_t>(v * width + u);
      ray.ray = {{view.origin.x(), view.origin.y(), view.origin.z()},
                 {direction.x(), direction.y(), direction.z()},
                 pixel_ray.norm()};
      ray.step = view.step / ray.ray.metres_per_depth;
      ray.walk = OccupiedIntervals(*view.distances, ray.ray, kNearDepth, kFarDepth);
      if (advance(ray)) active_.push_back(ray);
    }
  }
  while (!active_.empty()) {
    pending_.clear();
    x_.clear();
    y_.clear();
    z_.clear();
    for (std::uint32_t a = 0; a < active_.size(); ++a) {
      for (int k = 0; k < kSamplesPerRound && advance(active_[a]); ++k) collect(view, a);
    }
    shade(view);
    std::erase_if(active_, [](ActiveRay& ray) { return ray.transmittance <= kOpaque || !advance(ray); });
  }
}

/// Draws the tiles of one picture.
class TileRenderer {
public:
  TileRenderer(std::span<const LayerView> views, const Intrinsics& intrinsics, Picture& picture)
      : views_(views), intrinsics_(intrinsics), picture_(picture), layers_(views.size()), colors_(views.size()),
        opacities_(views.size()) {}

  void draw(int left, int top, int width, int height) {
    const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    for (std::size_t l = 0; l < views_.size(); ++l) {
      layers_[l].march(views_[l], intrinsics_, left, top, width, height);
      colors_[l].input.assign(pixels * kG, 0.0F);
      opacities_[l].assign(pixels, 0.0F);
    }
    for (std::size_t p = 0; p < pixels; ++p) {
      const int u = left + static_cast<int>(p) % width;
      const int v = top + static_cast<int>(p) / width;
      picture_.depth.at(u, v) = composite(p);
    }
    for (std::size_t l = 0; l < views_.size(); ++l) evaluate_colors(views_[l].layer->field, pixels, colors_[l]);
    for (std::size_t p = 0; p < pixels; ++p) {
      write(p, left + static_cast<int>(p) % width, top + static_cast<int>(p) / width);
    }
  }

private:
  // Front to back over the samples of all layers; returns the depth at which half of the light is gone, or 0.
  float composite(std::size_t p) {
    next_.assign(views_.size(), 0);
    float transmittance = 1;
    float median_depth = 0;
    while (transmittance > kOpaque) {
      std::size_t nearest = views_.size();
      for (std::size_t l = 0; l < views_.size(); ++l) {
        const auto& samples = layers_[l].rays()[p];
        if (next_[l] < samples.size() &&
            (nearest == views_.size() || samples[next_[l]].depth < layers_[nearest].rays()[p][next_[nearest]].depth)) {
          nearest = l;
        }
      }
      if (nearest == views_.size()) break;
      const ShadedSample& sample = layers_[nearest].rays()[p][next_[nearest]++];
      const float behind = transmittance * std::exp(-sample.optical_depth);
      const float weight = transmittance - behind;
      if (transmittance > 0.5F && behind <= 0.5F) median_depth = sample.depth;
      transmittance = behind;
      opacities_[nearest][p] += weight;
      float* input = colors_[nearest].input.data() + p * kG;
      for (std::size_t f = 0; f + 1 < kG; ++f) input[f] += weight * sample.features[f];
    }
    for (std::size_t l = 0; l < views_.size(); ++l) {
      float* input = colors_[l].input.data() + p * kG;
      const float normaliser = 1.0F / (opacities_[l][p] + kOpacityEpsilon);
      for (std::size_t f = 0; f + 1 < kG; ++f) input[f] *= normaliser;
      input[kG - 1] = 1;
    }
    return median_depth;
  }

  void write(std::size_t p, int u, int v) {
    float total = 0;
    float most = 0;
    std::array<float, 3> color{};
    for (std::size_t l = 0; l < views_.size(); ++l) {
      const float opacity = opacities_[l][p];
      total += opacity;
      for (std::size_t c = 0; c < 3; ++c) {
        color[c] += opacity / (1.0F + std::exp(-colors_[l].output[p * FieldConfig::kColorOutputs + c]));
      }
      if (opacity > most) {
        most = opacity;
        picture_.front.at(u, v) = static_cast<std::uint8_t>(l + 1);
      }
    }
    if (total <= 0) return;
    for (std::size_t c = 0; c < 3; ++c) picture_.color.at(u, v, static_cast<int>(c)) = to_byte(color[c] / total);
    picture_.color.at(u, v, 3) = to_byte(total > 1 - 2 * kOpaque ? 1.0F : total);
  }

  static std::uint8_t to_byte(float value) {
    return static_cast<std::uint8_t>(std::lround(255.0F * std::clamp(value, 0.0F, 1.0F)));
  }

  std::span<const LayerView> views_;
  const Intrinsics& intrinsics_;
  Picture& picture_;
  std::vector<LayerTile> layers_;
  std::vector<ColorBatch> colors_;
  std::vector<std::vector<float>> opacities_;
  std::vector<std::size_t> next_; // per layer, the sample that composite() looks at
};

} // namespace

Picture render(std::span<const PosedField> layers, const Camera& camera) {
  constexpr int kMaxSide = 16384;
  constexpr std::size_t kMaxLayers = 255;
  const Intrinsics& intrinsics = camera.intrinsics;
  if (intrinsics.width < 1 || intrinsics.height < 1 || intrinsics.width > kMaxSide || intrinsics.height > kMaxSide) {
    throw Error(ErrorCode::kUsage, "a picture must have between 1 and 16384 pixels on each side");
  }
  if (layers.size() > kMaxLayers) throw Error(ErrorCode::kUsage, "at most 255 layers can be drawn together");
  std::vector<LayerView> views;
  for (const PosedField& posed : layers) {
    const FieldConfig& config = posed.field->field().config;
    const FieldBox& box = posed.live ? posed.live->box() : config.box;
    const SE3 box_from_camera = posed.canonical_to_world.inverse() * camera.camera_to_world;
    views.push_back({&posed.field->derived(), posed.live.get(),
                     posed.live ? &posed.live->distances() : &posed.field->derived().distances,
                     ((box_from_camera.translation() - box.origin) / box.side).cast<float>(),
                     (box_from_camera.linear() / box.side).cast<float>(), static_cast<float>(config.cell_size())});
  }
  Picture picture{ColorImage(intrinsics.width, intrinsics.height, 4), DepthImage(intrinsics.width, intrinsics.height),
                  LabelImage(intrinsics.width, intrinsics.height)};
  const std::size_t columns = chunk_count(static_cast<std::size_t>(intrinsics.width), kTile);
  const std::size_t rows = chunk_count(static_cast<std::size_t>(intrinsics.height), kTile);
  parallel_for(rows, 1, [&](const Chunk& row) {
    TileRenderer tile(views, intrinsics, picture);
    const int top = static_cast<int>(row.begin) * kTile;
    for (std::size_t column = 0; column < columns; ++column) {
      const int left = static_cast<int>(column) * kTile;
      tile.draw(left, top, std::min(kTile, intrinsics.width - left), std::min(kTile, intrinsics.height - top));
    }
  });
  return picture;
}

} // namespace kinora::fields
