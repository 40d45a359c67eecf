#include "fields/renderer.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/parallel.h"
#include "fields/field_batch.h"
#include "fields/march.h"
#include "fields/rasterizer.h"
#include "fields/ray_batch.h"

namespace kinora::fields {

struct DrawableField::Derived {
  Field field;
  std::vector<GridLevel> levels;
  DensityBricks bricks;
  BrickHull hull;
};

DrawableField::DrawableField(Field field, const tracking::DeformationGraph* graph) {
  auto derived = std::make_shared<Derived>();
  derived->levels = grid_levels(field.config);
  derived->bricks = DensityBricks(field);
  derived->hull = BrickHull(derived->bricks, field.config.box);
  if (graph != nullptr) derived->hull.follow(*graph);
  derived->field = std::move(field);
  derived_ = std::move(derived);
}
const Field& DrawableField::field() const { return derived_->field; }

PosedField pose(const DrawableField& field, const tracking::Warp& warp) {
  if (warp.is_rigid()) return {&field, warp.rigid()};
  const BrickHull& hull = field.derived().hull;
  if (hull.influences().size() != hull.corners().size()) {
    throw Error(ErrorCode::kFailure, "a field that was not made to deform cannot be drawn deformed");
  }
  return {&field, SE3::Identity(), std::make_shared<const PosedHull>(hull, warp),
          std::make_shared<const tracking::Warp>(warp)};
}

namespace {

constexpr int kTile = TriangleBins::kTile;
constexpr float kNearDepth = 0.02F;   // metres: nothing nearer is drawn
constexpr float kNegligible = 0.004F; // share of a pixel's light below which a surface is not looked at
constexpr float kSamePlace = 2;       // lattice steps: an entry that near to a ray that is under way belongs to it
constexpr std::size_t kG = FieldConfig::kGeometry;
constexpr std::size_t kO = FieldConfig::kColorOutputs;
/// Entry::triangle of rays that begin inside of a hull, before the camera.
constexpr std::uint32_t kInside = 0xFFFFFFFF;

/// A layer as the camera sees it. Lattice coordinates are those of its bricks.
class LayerView {
public:
  LayerView(const PosedField& posed, const Camera& camera, DrawQuality quality);

  const DrawableField::Derived& layer() const { return *layer_; }
  DrawQuality quality() const { return quality_; }
  float step() const { return step_; }                                     ///< metres between samples
  float optical_length() const { return optical_length_; }                 ///< of a step
  const std::vector<Eigen::Vector3f>& corners() const { return corners_; } ///< in the camera's frame, metres
  const std::vector<HullFace>& faces() const { return *faces_; }
  bool holds_camera() const { return holds_camera_; }

  /// Where a ray of the camera, (x, y, 1) in its frame, is at an entry's depth, and its way from the camera to there.
  struct Place {
    Eigen::Vector3f at;
    Eigen::Vector3f way;
  };
  Place place_of(const Entry& entry, const TriangleBins& bins, const Eigen::Vector3f& ray) const;
  /// `at` moved to where the layer's motion, interpolated among the corners of the brick, carries it to `point` in the
  /// camera's frame. Only for layers that deform.
  Eigen::Vector3f refined(Eigen::Vector3f at, const Eigen::Vector3f& point) const;
  bool deforms() const { return cells_ != nullptr; }
  /// A place, or a way, relative to the field's box.
  std::array<float, 3> to_box(const Eigen::Vector3f& lattice) const {
    const float scale = 1.0F / static_cast<float>(layer_->bricks.resolution());
    return {lattice.x() * scale, lattice.y() * scale, lattice.z() * scale};
  }

private:
  void look(const SE3& canonical_from_camera, const SE3& camera_from_canonical);
  void look(const PosedHull& hull, const SE3& camera_from_world);
  void stand(const SE3& canonical_from_camera);
  Eigen::Vector3f to_lattice(const Eigen::Vector3d& canonical) const {
    return ((canonical - layer_->field.config.box.origin) * lattice_per_metre_).cast<float>();
  }

  const DrawableField::Derived* layer_;
  DrawQuality quality_;
  double lattice_per_metre_;
  float step_;
  float optical_length_;
  std::vector<Eigen::Vector3f> corners_;
  std::vector<Eigen::Vector3f> places_; // of the corners, lattice
  std::vector<Eigen::Vector3f> ways_;   // from the camera to the corners, turned into canonical space, lattice
  const std::vector<HullFace>* faces_ = nullptr;
  const std::vector<std::array<std::uint32_t, 8>>* cells_ = nullptr; // of a layer that deforms
  bool holds_camera_ = false;
  Eigen::Vector3f camera_place_ = Eigen::Vector3f::Zero();    // lattice
  Eigen::Matrix3f camera_turn_ = Eigen::Matrix3f::Identity(); // camera's frame to lattice
};

LayerView::LayerView(const PosedField& posed, const Camera& camera, DrawQuality quality)
    : layer_(&posed.field->derived()), quality_(quality) {
  const FieldConfig& config = layer_->field.config;
  lattice_per_metre_ = layer_->bricks.resolution() / config.box.side;
  // As far apart as in training, or as the lattice can tell.
  const double sample = std::max(config.cell_size(), 1 / lattice_per_metre_);
  step_ = static_cast<float>(quality == DrawQuality::kFull ? sample : 2 * sample);
  optical_length_ = static_cast<float>(step_ / config.density_length());
  const SE3 camera_from_world = camera.camera_to_world.inverse();
  if (posed.hull == nullptr) {
    const SE3 canonical_from_camera = posed.canonical_to_world.inverse() * camera.camera_to_world;
    look(canonical_from_camera, canonical_from_camera.inverse());
    return;
  }
  look(*posed.hull, camera_from_world);
  const Eigen::Vector3d& centre = camera.camera_to_world.translation();
  if (const auto canonical = posed.warp->to_canonical(centre)) {
    SE3 canonical_from_camera = SE3::Identity();
    canonical_from_camera.linear() = posed.warp->at(*canonical)->linear().transpose() * camera.camera_to_world.linear();
    canonical_from_camera.translation() = *canonical;
    stand(canonical_from_camera);
  }
}

// A rigid layer.
void LayerView::look(const SE3& canonical_from_camera, const SE3& camera_from_canonical) {
  stand(canonical_from_camera);
  const BrickHull& hull = layer_->hull;
  corners_.resize(hull.corners().size());
  places_.resize(hull.corners().size());
  ways_.resize(hull.corners().size());
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    corners_[i] = (camera_from_canonical * hull.corners()[i]).cast<float>();
    places_[i] = to_lattice(hull.corners()[i]);
    ways_[i] = places_[i] - camera_place_;
  }
  faces_ = &hull.faces();
}

// A deforming one.
void LayerView::look(const PosedHull& hull, const SE3& camera_from_world) {
  const Eigen::Vector3d centre = camera_from_world.inverse().translation();
  corners_.resize(hull.corners().size());
  places_.resize(hull.corners().size());
  ways_.resize(hull.corners().size());
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    const PosedHull::Corner& corner = hull.corners()[i];
    corners_[i] = (camera_from_world * corner.world).cast<float>();
    places_[i] = to_lattice(corner.canonical);
    ways_[i] = (corner.canonical_from_world * (corner.world - centre) * lattice_per_metre_).cast<float>();
  }
  faces_ = &hull.faces();
  cells_ = &hull.cells();
}

void LayerView::stand(const SE3& canonical_from_camera) {
  camera_place_ = to_lattice(canonical_from_camera.translation());
  camera_turn_ = (canonical_from_camera.linear() * lattice_per_metre_).cast<float>();
  const auto brick = [this](int axis) {
    return static_cast<int>(std::floor(std::clamp(camera_place_[axis], -1e6F, 1e6F) / DensityBricks::kSide));
  };
  holds_camera_ = layer_->bricks.brick_at(brick(0), brick(1), brick(2)) >= 0;
}

LayerView::Place LayerView::place_of(const Entry& entry, const TriangleBins& bins, const Eigen::Vector3f& ray) const {
  if (entry.triangle == kInside) {
    const Eigen::Vector3f way = camera_turn_ * ray * entry.depth;
    return {camera_place_ + way, way};
  }
  const HullTriangle& triangle = bins.triangles()[entry.triangle];
  Place place{Eigen::Vector3f::Zero(), Eigen::Vector3f::Zero()};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& row = triangle.rows[i];
    const float share = (row[0] * ray.x() + row[1] * ray.y() + row[2]) * entry.depth;
    place.at += share * places_[triangle.corners[i]];
    place.way += share * ways_[triangle.corners[i]];
  }
  return place;
}

Eigen::Vector3f LayerView::refined(Eigen::Vector3f at, const Eigen::Vector3f& point) const {
  const int iterations = quality_ == DrawQuality::kFull ? 2 : 1;
  constexpr float kSide = BrickHull::kCellSide;
  for (int k = 0; k < iterations; ++k) {
    const Eigen::Vector3f in_cells = at / kSide;
    const Eigen::Vector3f low = in_cells.array().floor();
    const int number = layer_->hull.cell_at(layer_->bricks, static_cast<int>(low.x()), static_cast<int>(low.y()),
                                            static_cast<int>(low.z()));
    if (number < 0) return at;
    const auto& corners = (*cells_)[static_cast<std::size_t>(number)];
    const Eigen::Vector3f f = in_cells - low;
    Eigen::Vector3f value = Eigen::Vector3f::Zero();
    Eigen::Matrix3f jacobian = Eigen::Matrix3f::Zero();
    for (int c = 0; c < 8; ++c) {
      const Eigen::Vector3f& corner = corners_[corners[static_cast<std::size_t>(c)]];
      const float wx = (c & 1) ? f.x() : 1 - f.x(), wy = (c & 2) ? f.y() : 1 - f.y(), wz = (c & 4) ? f.z() : 1 - f.z();
      value += wx * wy * wz * corner;
      jacobian.col(0) += ((c & 1) ? 1 : -1) * wy * wz * corner;
      jacobian.col(1) += ((c & 2) ? 1 : -1) * wx * wz * corner;
      jacobian.col(2) += ((c & 4) ? 1 : -1) * wx * wy * corner;
    }
    const Eigen::Vector3f step = kSide * (jacobian.inverse() * (point - value));
    if (!(step.squaredNorm() < kSide * kSide)) return at;
    at += step;
  }
  return at;
}

/// What a pixel's ray meets in a layer.
struct Surface {
  float depth; ///< metres
  float opacity;
  std::uint32_t layer;
  std::array<float, 3> position; ///< relative to the field's box, where the light is taken away in the mean
  std::array<float, 3> spread;   ///< its standard deviation along the ray
};
using Surfaces = PixelLists<Surface, 8>;

/// Finds the surfaces of one layer in a tile.
class TileMarcher {
public:
  void march(const LayerView& view, std::uint32_t layer, const TriangleBins& bins,
             const std::vector<Eigen::Vector3f>& pixel_rays, const Entries& entries, Surfaces& surfaces);

private:
  struct Ray {
    std::uint32_t pixel;
    std::size_t next; // entry
    float entry_depth;
    float depth_step;
    Eigen::Vector3f origin, direction;
  };
  // Stands the ray at its next entry that is not one of where it comes from; false if there is none.
  static bool enter(const LayerView& view, const TriangleBins& bins, const Eigen::Vector3f& pixel_ray,
                    std::span<const Entry> entries, float until_depth, Ray& ray, float& begin);

  std::vector<Ray> rays_;
  std::vector<MarchRay> march_rays_;
  std::vector<float> begin_;
  std::vector<MarchRun> runs_;
};

bool TileMarcher::enter(const LayerView& view, const TriangleBins& bins, const Eigen::Vector3f& pixel_ray,
                        std::span<const Entry> entries, float until_depth, Ray& ray, float& begin) {
  while (ray.next < entries.size()) {
    const Entry& entry = entries[ray.next];
    const LayerView::Place place = view.place_of(entry, bins, pixel_ray);
    if (ray.next++ > 0 && entry.depth < until_depth) {
      const Eigen::Vector3f before = ray.origin + (entry.depth - ray.entry_depth) / ray.depth_step * ray.direction;
      if ((place.at - before).squaredNorm() < kSamePlace * kSamePlace) continue;
    }
    // Samples lie on a ladder of depths that does not know of the hull, the first one behind the entry.
    ray.depth_step = view.step() / pixel_ray.norm();
    ray.direction = place.way * (ray.depth_step / entry.depth);
    const float rung = std::ceil(entry.depth / ray.depth_step - 0.5F);
    ray.entry_depth = rung * ray.depth_step;
    ray.origin = place.at + (rung - entry.depth / ray.depth_step) * ray.direction;
    begin = std::max(0.0F, std::ceil((kNearDepth - ray.entry_depth) / ray.depth_step));
    return true;
  }
  return false;
}

void TileMarcher::march(const LayerView& view, std::uint32_t layer, const TriangleBins& bins,
                        const std::vector<Eigen::Vector3f>& pixel_rays, const Entries& entries, Surfaces& surfaces) {
  rays_.clear();
  begin_.clear();
  for (std::uint32_t p = 0; p < pixel_rays.size(); ++p) {
    if (entries.of(p).empty()) continue;
    Ray ray{p, 0, 0, 1, Eigen::Vector3f::Zero(), Eigen::Vector3f::Zero()};
    float begin = 0;
    enter(view, bins, pixel_rays[p], entries.of(p), 0, ray, begin);
    rays_.push_back(ray);
    begin_.push_back(begin);
  }
  while (!rays_.empty()) {
    const std::size_t n = rays_.size();
    march_rays_.resize(n);
    runs_.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      const Ray& ray = rays_[i];
      march_rays_[i] = {{ray.origin.x(), ray.origin.y(), ray.origin.z()},
                        {ray.direction.x(), ray.direction.y(), ray.direction.z()}};
    }
    fields::march(view.layer().bricks, march_rays_.data(), begin_.data(), n, view.optical_length(), runs_.data());
    std::size_t kept = 0;
    for (std::size_t i = 0; i < n; ++i) {
      Ray ray = rays_[i];
      const MarchRun& run = runs_[i];
      if (run.opacity > kNegligible) {
        const float depth = ray.entry_depth + run.mean * ray.depth_step;
        Eigen::Vector3f at = ray.origin + run.mean * ray.direction;
        if (view.deforms()) at = view.refined(at, depth * pixel_rays[ray.pixel]);
        surfaces.insert(ray.pixel, {ray.entry_depth + run.median * ray.depth_step, run.opacity, layer, view.to_box(at),
                                    view.to_box(run.spread * ray.direction)});
      }
      if (run.reason == RunEnd::kOpaque) continue;
      float begin = run.end;
      if (run.reason == RunEnd::kLeft && !enter(view, bins, pixel_rays[ray.pixel], entries.of(ray.pixel),
                                                ray.entry_depth + run.end * ray.depth_step, ray, begin)) {
        continue;
      }
      rays_[kept] = ray;
      begin_[kept++] = begin;
    }
    rays_.resize(kept);
    begin_.resize(kept);
  }
}

/// Colours of the surfaces of one layer in a tile that are seen.
class TileShader {
public:
  void clear() {
    for (std::vector<float>* values : {&x_, &y_, &z_, &weights_, &opacities_}) values->clear();
    rows_.clear();
    pixels_.clear();
  }
  /// Pixels in ascending order.
  void add(std::uint32_t pixel, const Surface& surface, float weight, DrawQuality quality) {
    if (pixels_.empty() || pixels_.back() != pixel) {
      pixels_.push_back(pixel);
      opacities_.push_back(0);
    }
    opacities_.back() += weight;
    if (quality == DrawQuality::kFast) return add_point(surface, 0, weight);
    add_point(surface, -1, 0.5F * weight);
    add_point(surface, 1, 0.5F * weight);
  }
  void shade(const DrawableField::Derived& layer);

  const std::vector<std::uint32_t>& pixels() const { return pixels_; }
  float opacity(std::size_t row) const { return opacities_[row]; }
  std::array<float, 3> color(std::size_t row) const {
    std::array<float, 3> rgb{};
    for (std::size_t c = 0; c < 3; ++c) rgb[c] = 1.0F / (1.0F + std::exp(-color_.output[row * kO + c]));
    return rgb;
  }

private:
  void add_point(const Surface& surface, float side, float weight) {
    x_.push_back(surface.position[0] + side * surface.spread[0]);
    y_.push_back(surface.position[1] + side * surface.spread[1]);
    z_.push_back(surface.position[2] + side * surface.spread[2]);
    weights_.push_back(weight);
    rows_.push_back(static_cast<std::uint32_t>(pixels_.size() - 1));
  }

  std::vector<float> x_, y_, z_, weights_; // per point
  std::vector<std::uint32_t> rows_;        // per point
  std::vector<std::uint32_t> pixels_;      // per row
  std::vector<float> opacities_;           // per row
  PointBatch points_;
  ColorBatch color_;
};

void TileShader::shade(const DrawableField::Derived& layer) {
  if (pixels_.empty()) return;
  evaluate_points(layer.field, layer.levels, {x_.data(), y_.data(), z_.data(), x_.size()}, points_);
  color_.input.assign(pixels_.size() * kG, 0.0F);
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const float* g = points_.geometry.data() + i * kG;
    float* input = color_.input.data() + rows_[i] * kG;
    const float share = weights_[i] / (opacities_[rows_[i]] + kOpacityEpsilon);
    for (std::size_t f = 0; f + 1 < kG; ++f) input[f] += share * g[f + 1];
    input[kG - 1] = 1;
  }
  evaluate_colors(layer.field, pixels_.size(), color_);
}

/// Draws tiles; buffers are kept.
class TileRenderer {
public:
  TileRenderer(std::span<const LayerView> views, const TriangleBins& bins, const Intrinsics& intrinsics,
               Picture& picture)
      : views_(views), bins_(bins), intrinsics_(intrinsics), picture_(picture), shaders_(views.size()) {}

  void draw(int column, int row) {
    left_ = column * kTile;
    top_ = row * kTile;
    if (!find_surfaces(bins_.of_tile(column, row))) return;
    for (TileShader& shader : shaders_) shader.clear();
    for (std::uint32_t p = 0; p < rays_.size(); ++p) composite(p);
    colors_.assign(rays_.size(), {0, 0, 0});
    most_.assign(rays_.size(), 0.0F);
    totals_.assign(rays_.size(), 0.0F);
    for (std::size_t l = 0; l < views_.size(); ++l) add_colors(l);
    for (std::size_t p = 0; p < rays_.size(); ++p) write(p);
  }

private:
  int u_of(std::size_t p) const { return left_ + static_cast<int>(p) % kTile; }
  int v_of(std::size_t p) const { return top_ + static_cast<int>(p) / kTile; }

  void find_rays() {
    rays_.resize(Entries::kPixels);
    const Eigen::Vector3f first = intrinsics_.unproject(left_, top_, 1.0).cast<float>();
    const auto dx = static_cast<float>(1 / intrinsics_.fx);
    const auto dy = static_cast<float>(1 / intrinsics_.fy);
    for (std::size_t p = 0; p < rays_.size(); ++p) {
      const std::size_t column = p % kTile;
      const std::size_t row = p / kTile;
      rays_[p] = {first.x() + static_cast<float>(column) * dx, first.y() + static_cast<float>(row) * dy, 1};
    }
  }

  // False if no layer has anything here.
  bool find_surfaces(std::span<const std::uint32_t> triangles) {
    const auto holds_camera = [](const LayerView& view) { return view.holds_camera(); };
    if (triangles.empty() && std::none_of(views_.begin(), views_.end(), holds_camera)) return false;
    find_rays();
    surfaces_.clear();
    std::size_t next = 0;
    for (std::uint32_t l = 0; l < views_.size(); ++l) {
      entries_.clear();
      bool any = views_[l].holds_camera();
      if (any) {
        for (std::size_t p = 0; p < Entries::kPixels; ++p) entries_.insert(p, {kNearDepth, kInside});
      }
      for (; next < triangles.size() && bins_.triangles()[triangles[next]].layer == l; ++next) {
        rasterize(bins_.triangles()[triangles[next]], triangles[next], intrinsics_, left_, top_, entries_);
        any = true;
      }
      if (any) marcher_.march(views_[l], l, bins_, rays_, entries_, surfaces_);
    }
    return true;
  }

  // Front to back over the surfaces of all layers: what is seen of each goes to its layer's shader.
  void composite(std::uint32_t p) {
    if (!in_picture(p)) return;
    float transmittance = 1;
    float median_depth = 0;
    for (const Surface& surface : surfaces_.of(p)) {
      const float weight = transmittance * surface.opacity;
      if (weight > kNegligible) {
        shaders_[surface.layer].add(p, surface, weight, views_[surface.layer].quality());
      }
      if (transmittance > 0.5F && transmittance - weight <= 0.5F) median_depth = surface.depth;
      transmittance -= weight;
      if (transmittance <= kOpaque) break;
    }
    picture_.depth.at(u_of(p), v_of(p)) = median_depth;
  }

  void add_colors(std::size_t l) {
    TileShader& shader = shaders_[l];
    shader.shade(views_[l].layer());
    for (std::size_t row = 0; row < shader.pixels().size(); ++row) {
      const std::uint32_t p = shader.pixels()[row];
      const float opacity = shader.opacity(row);
      const std::array<float, 3> color = shader.color(row);
      for (std::size_t c = 0; c < 3; ++c) colors_[p][c] += opacity * color[c];
      totals_[p] += opacity;
      if (opacity > most_[p]) {
        most_[p] = opacity;
        picture_.front.at(u_of(p), v_of(p)) = static_cast<std::uint8_t>(l + 1);
      }
    }
  }

  void write(std::size_t p) {
    if (totals_[p] <= 0) return;
    std::uint8_t* pixel = picture_.color.pixel(u_of(p), v_of(p));
    for (std::size_t c = 0; c < 3; ++c) pixel[c] = to_byte(colors_[p][c] / totals_[p]);
    pixel[3] = to_byte(totals_[p] > 1 - 2 * kOpaque ? 1.0F : totals_[p]);
  }

  bool in_picture(std::size_t p) const { return u_of(p) < intrinsics_.width && v_of(p) < intrinsics_.height; }
  static std::uint8_t to_byte(float value) {
    return static_cast<std::uint8_t>(std::lround(255.0F * std::clamp(value, 0.0F, 1.0F)));
  }

  std::span<const LayerView> views_;
  const TriangleBins& bins_;
  const Intrinsics& intrinsics_;
  Picture& picture_;
  int left_ = 0, top_ = 0;
  std::vector<Eigen::Vector3f> rays_; // per pixel, (x, y, 1)
  Entries entries_;
  Surfaces surfaces_;
  TileMarcher marcher_;
  std::vector<TileShader> shaders_;          // per layer
  std::vector<std::array<float, 3>> colors_; // per pixel, times opacity
  std::vector<float> totals_, most_;         // per pixel: opacity of all layers, and of the one that has most
};

} // namespace

Picture render(std::span<const PosedField> layers, const Camera& camera, DrawQuality quality) {
  constexpr int kMaxSide = 16384;
  constexpr std::size_t kMaxLayers = 255;
  const Intrinsics& intrinsics = camera.intrinsics;
  if (intrinsics.width < 1 || intrinsics.height < 1 || intrinsics.width > kMaxSide || intrinsics.height > kMaxSide) {
    throw Error(ErrorCode::kUsage, "a picture must have between 1 and 16384 pixels on each side");
  }
  if (layers.size() > kMaxLayers) throw Error(ErrorCode::kUsage, "at most 255 layers can be drawn together");
  std::vector<LayerView> views;
  TriangleBins bins(intrinsics);
  for (const PosedField& posed : layers) {
    views.emplace_back(posed, camera, quality);
    bins.add(static_cast<std::uint8_t>(views.size() - 1), views.back().corners(), views.back().faces());
  }
  bins.sort();
  Picture picture{ColorImage(intrinsics.width, intrinsics.height, 4), DepthImage(intrinsics.width, intrinsics.height),
                  LabelImage(intrinsics.width, intrinsics.height)};
  parallel_for(static_cast<std::size_t>(bins.rows()), 1, [&](const Chunk& row) {
    TileRenderer tile(views, bins, intrinsics, picture);
    for (int column = 0; column < bins.columns(); ++column) tile.draw(column, static_cast<int>(row.begin));
  });
  return picture;
}

} // namespace kinora::fields
