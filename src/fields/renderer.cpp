#include "fields/renderer.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/parallel.h"
#include "fields/layer_view.h"
#include "fields/tile_marcher.h"
#include "fields/tile_shader.h"

namespace kinora::fields {

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

/// Draws tiles; buffers are kept.
class TileRenderer {
public:
  TileRenderer(std::span<const LayerView> views, const TriangleBins& bins, const Intrinsics& intrinsics,
               const DrawOptions& options, Picture& picture)
      : views_(views), bins_(bins), intrinsics_(intrinsics), options_(options), picture_(picture),
        shaders_(views.size()) {}

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
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();
    for (const Surface& surface : surfaces_.of(p)) {
      const float weight = transmittance * surface.opacity;
      const LayerView& view = views_[surface.layer];
      if (weight > kNegligible) {
        shaders_[surface.layer].add(p, surface, weight, options_.quality);
        if (options_.normals) normal += weight * view.normal_at(view.from_box(surface.position));
      }
      if (transmittance > 0.5F && transmittance - weight <= 0.5F) median_depth = surface.depth;
      transmittance -= weight;
      if (transmittance <= kOpaque) break;
    }
    picture_.depth.at(u_of(p), v_of(p)) = median_depth;
    if (options_.normals && median_depth > 0) write_normal(p, normal);
  }

  // Towards the camera where none is known.
  void write_normal(std::uint32_t p, Eigen::Vector3f normal) {
    if (normal.squaredNorm() < 1e-12F) normal = -rays_[p];
    normal.normalize();
    std::copy_n(normal.data(), 3, picture_.normal.pixel(u_of(p), v_of(p)));
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
  const DrawOptions& options_;
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

Picture render(std::span<const PosedField> layers, const Camera& camera, const DrawOptions& options) {
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
    views.emplace_back(posed, camera, options.quality);
    bins.add(static_cast<std::uint8_t>(views.size() - 1), views.back().corners(), views.back().faces());
  }
  bins.sort();
  Picture picture{ColorImage(intrinsics.width, intrinsics.height, 4), DepthImage(intrinsics.width, intrinsics.height),
                  LabelImage(intrinsics.width, intrinsics.height)};
  if (options.normals) picture.normal = Image<float>(intrinsics.width, intrinsics.height, 3);
  parallel_for(static_cast<std::size_t>(bins.rows()), 1, [&](const Chunk& row) {
    TileRenderer tile(views, bins, intrinsics, options, picture);
    for (int column = 0; column < bins.columns(); ++column) tile.draw(column, static_cast<int>(row.begin));
  });
  return picture;
}

} // namespace kinora::fields
