#include "fields/rendering/renderer.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/parallel.h"
#include "fields/rendering/projected_layer.h"
#include "fields/rendering/tile_marcher.h"
#include "fields/rendering/tile_samples.h"
#include "fields/rendering/tile_shader.h"
#include "fields/rendering/upsampling.h"

namespace kinora::fields {

DrawableField::DrawableField(Field field, const motion::DeformationGraph* graph, std::optional<Confidence> confidence,
                             BrickDetail detail)
    : DrawableField(std::make_shared<const Field>(std::move(field)), graph, std::move(confidence), detail) {}

DrawableField::DrawableField(std::shared_ptr<const Field> field, const motion::DeformationGraph* graph,
                             std::optional<Confidence> confidence, BrickDetail detail) {
  auto derived = std::make_shared<Derived>(std::move(field));
  derived->levels = stored_levels(derived->field);
  derived->surface_matrix = surface_matrix(derived->field);
  derived->vector_matrix = vector_matrix(derived->field);
  derived->bricks = DensityBricks(derived->field, detail);
  derived->proxy_mesh = ProxyMesh(derived->bricks, derived->field.config.box);
  if (graph != nullptr) derived->proxy_mesh.bind_to(*graph);
  derived->confidence = std::move(confidence);
  derived_ = std::move(derived);
}
const Field& DrawableField::field() const { return derived_->field; }

namespace {

/// Numbers of bricks as the bricks' own, without those that are not there yet.
std::vector<std::int32_t> index_of(const DensityBricks& bricks, const std::vector<std::uint8_t>& born) {
  const auto n = static_cast<std::size_t>(bricks.bricks_per_side());
  std::vector<std::int32_t> index(bricks.index(), bricks.index() + n * n * n);
  for (std::int32_t& brick : index) {
    if (brick >= 0 && born[static_cast<std::size_t>(brick)] == 0) brick = -1;
  }
  return index;
}

} // namespace

PosedField pose(const DrawableField& field, const motion::Warp& warp, const motion::UnbornNodes& unborn) {
  if (warp.is_rigid()) return {&field, warp.rigid()};
  const ProxyMesh& proxy_mesh = field.derived().proxy_mesh;
  if (proxy_mesh.influences().count != proxy_mesh.corner_count()) {
    throw Error(ErrorCode::kFailure, "a field that was not made to deform cannot be drawn deformed");
  }
  const std::vector<std::uint8_t> born = proxy_mesh.born_bricks(unborn);
  PosedField posed{&field, SE3::Identity(), std::make_shared<const PosedProxyMesh>(proxy_mesh, warp, born),
                   std::make_shared<const motion::Warp>(warp)};
  if (!born.empty())
    posed.brick_index = std::make_shared<const std::vector<std::int32_t>>(index_of(field.derived().bricks, born));
  return posed;
}

namespace {

constexpr int kTile = TriangleBins::kTile;
constexpr int kMaxSide = 16384;
static_assert(kTile % DrawOptions::kMaxSamples == 0);

/// Draws tiles; buffers are kept.
class TileRenderer {
public:
  /// `intrinsics`: of the samples, `per_side`² of which make a pixel.
  TileRenderer(std::span<const ProjectedLayer> views, const TriangleBins& bins, const Intrinsics& intrinsics,
               int per_side, const DrawOptions& options, Picture& picture)
      : views_(views), bins_(bins), intrinsics_(intrinsics), per_side_(per_side), options_(options), picture_(picture) {
    for (const ProjectedLayer& view : views) {
      marchers_.emplace_back(view, static_cast<std::uint32_t>(marchers_.size()), bins);
      shaders_.emplace_back(view.layer());
    }
  }

  void draw(int column, int row) {
    left_ = column * kTile;
    top_ = row * kTile;
    if (!find_entries(bins_.of_tile(column, row))) return;
    surfaces_.clear();
    for (TileMarcher& marcher : marchers_) marcher.march_anchors(rays_, surfaces_);
    samples_.clear();
    const int columns = std::min(kTile, intrinsics_.width - left_);
    const int rows = std::min(kTile, intrinsics_.height - top_);
    for (const bool between : {false, true}) {
      pixels_.clear();
      for (int v = 0; v < rows; ++v) {
        for (int u = (v + (between ? 1 : 0)) % 2; u < columns; u += 2) {
          const auto p = static_cast<std::uint32_t>(v * kTile + u);
          if (!between || !samples_.fill(p)) pixels_.push_back(p);
        }
      }
      draw_pixels();
    }
    for (int v = 0; v < kTile; v += per_side_) {
      for (int u = 0; u < kTile; u += per_side_) write(u, v);
    }
  }

private:
  void find_rays(const TileRays& tile) {
    auto* next = rays_.data();
    for (int row = 0; row < kTile; ++row) {
      for (int column = 0; column < kTile; ++column) {
        const Eigen::Vector3f ray(tile.x + static_cast<float>(column) * tile.dx,
                                  tile.y + static_cast<float>(row) * tile.dy, 1);
        *next++ = {ray, 1 / ray.norm()};
      }
    }
  }

  // False if no layer has anything here.
  bool find_entries(std::span<const std::uint32_t> triangles) {
    const auto contains_camera = [](const ProjectedLayer& view) { return view.contains_camera(); };
    if (triangles.empty() && std::none_of(views_.begin(), views_.end(), contains_camera)) return false;
    const TileRays tile = tile_rays(intrinsics_, left_, top_);
    find_rays(tile);
    for (std::size_t l = 0; l < views_.size(); ++l) {
      Entries& entries = marchers_[l].entries();
      entries.clear();
      if (!views_[l].contains_camera()) continue;
      for (std::size_t p = 0; p < Entries::kPixels; ++p) entries.insert(p, {kNearDepth, kInside});
    }
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      constexpr std::size_t kAhead = 4; // they are scattered, and asked for before they are needed
      if (i + kAhead < triangles.size()) __builtin_prefetch(&bins_.triangle(triangles[i + kAhead]));
      const ProxyTriangle& triangle = bins_.triangle(triangles[i]);
      rasterize(triangle, triangles[i], tile, marchers_[triangle.layer].entries());
    }
    return true;
  }

  void draw_pixels() {
    for (TileMarcher& marcher : marchers_) marcher.march(rays_, pixels_, surfaces_);
    for (TileShader& shader : shaders_) shader.clear();
    for (const std::uint32_t p : pixels_) composite(p);
    for (std::uint32_t l = 0; l < shaders_.size(); ++l) {
      TileShader& shader = shaders_[l];
      shader.shade();
      for (std::size_t row = 0; row < shader.pixels().size(); ++row) {
        samples_[shader.pixels()[row]].add(l, shader.color(row), shader.opacity(row));
      }
    }
  }

  // Front to back over the surfaces of all layers: what is seen of each goes to its layer's shader.
  void composite(std::uint32_t p) {
    Sample& sample = samples_[p];
    float transmittance = 1;
    for (std::size_t i = 0; i < surfaces_.count(p); ++i) {
      const Surface& surface = surfaces_.at(p, i);
      const ProjectedLayer& view = views_[surface.layer];
      const auto lattice_position = [&] { return view.from_box(surface.position); };
      float weight = transmittance * surface.opacity;
      if (options_.unseen == Unseen::kFade && weight > kMinShare)
        weight *= view.visible_share(lattice_position(), rays_[p].view_vector);
      if (weight > kMinShare) {
        shaders_[surface.layer].add(p, surface, weight);
        if (options_.normals) sample.normal += weight * view.normal_at(lattice_position());
        if (options_.confidence)
          sample.confidence += weight * view.confidence_at(lattice_position(), rays_[p].view_vector);
      }
      if (transmittance > 0.5F && transmittance - weight <= 0.5F) sample.depth = surface.depth;
      transmittance -= weight;
      if (transmittance <= kOpaque) break;
    }
    // Towards the camera where none is known.
    if (options_.normals && sample.depth > 0) {
      if (sample.normal.squaredNorm() <= 1e-12F) sample.normal = -rays_[p].view_vector;
      sample.normal.normalize();
    }
  }

  // One pixel out of the samples from (left, top) in the tile: colours are averaged by their opacity, in sRGB as
  // pictures are compared; depth is that of the samples in the middle of all from near to far.
  void write(int left, int top) {
    const int first = top * kTile + left;
    if (per_side_ == 1) {
      const Sample& sample = samples_[static_cast<std::size_t>(first)];
      if (sample.front > 0) put(left_ + left, top_ + top, sample, sample.color, shown(sample));
      return;
    }
    order_.clear();
    Eigen::Array4f color = Eigen::Array4f::Zero();
    float drawn = 0, confidence = 0;
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();
    for (int v = 0; v < per_side_; ++v) {
      for (int u = 0; u < per_side_; ++u) {
        const int number = first + v * kTile + u;
        const Sample& sample = samples_[static_cast<std::size_t>(number)];
        order_.push_back(&sample);
        color += sample.color;
        drawn += shown(sample);
        normal += sample.normal;
        confidence += sample.confidence;
      }
    }
    if (color[3] <= 0) return;
    Sample middle = middle_sample();
    if (const float length = normal.norm(); length > 1e-6F) middle.normal = normal / length;
    middle.confidence = confidence;
    put((left_ + left) / per_side_, (top_ + top) / per_side_, middle, color,
        drawn / static_cast<float>(per_side_ * per_side_));
  }
  static float shown(const Sample& sample) { return sample.color[3] > 1 - 2 * kOpaque ? 1.0F : sample.color[3]; }

  // `color` and the confidence of `middle`: times opacity, of all the pixel's samples.
  void put(int u, int v, const Sample& middle, const Eigen::Array4f& color, float alpha) {
    Eigen::Array4f straight = color / color[3];
    straight[3] = alpha;
    const Eigen::Array4i bytes = (255 * straight.max(0).min(1) + 0.5F).cast<int>();
    std::copy_n(bytes.data(), 4, picture_.color.pixel(u, v));
    picture_.depth.at(u, v) = middle.depth;
    picture_.front.at(u, v) = middle.front;
    if (options_.normals && middle.depth > 0) std::copy_n(middle.normal.data(), 3, picture_.normal.pixel(u, v));
    if (options_.confidence && middle.depth > 0) picture_.confidence.at(u, v) = to_byte(middle.confidence / color[3]);
  }
  // Of order_, from near to far.
  const Sample& middle_sample() {
    const auto middle = order_.begin() + static_cast<std::ptrdiff_t>(order_.size() / 2);
    std::nth_element(order_.begin(), middle, order_.end(), is_nearer);
    return **middle;
  }
  // What is not met is farthest; the more opaque is before it.
  static bool is_nearer(const Sample* a, const Sample* b) {
    if (a->depth > 0 && b->depth > 0) return a->depth < b->depth;
    return a->depth > 0 || (!(b->depth > 0) && a->max_share > b->max_share);
  }

  static std::uint8_t to_byte(float value) {
    return static_cast<std::uint8_t>(std::lrint(255.0F * std::clamp(value, 0.0F, 1.0F)));
  }

  std::span<const ProjectedLayer> views_;
  const TriangleBins& bins_;
  const Intrinsics& intrinsics_;
  int per_side_;
  const DrawOptions& options_;
  Picture& picture_;
  int left_ = 0, top_ = 0;
  PixelRays rays_;
  std::vector<TileMarcher> marchers_; // per layer
  std::vector<TileShader> shaders_;   // per layer
  Surfaces surfaces_;
  std::vector<std::uint32_t> pixels_; // that are drawn together
  TileSamples samples_;
  std::vector<const Sample*> order_; // of a pixel
};

// With half the samples along each side.
Picture render_fast(std::span<const PosedField> layers, const Camera& camera, DrawOptions options) {
  options.quality = DrawQuality::kFull;
  if (options.samples > 1) {
    options.samples /= 2;
    return render(layers, camera, options);
  }
  const Intrinsics& intrinsics = camera.intrinsics;
  Camera half = camera;
  half.intrinsics = intrinsics.resized((intrinsics.width + 1) / 2, (intrinsics.height + 1) / 2);
  return upsampled(render(layers, half, options), intrinsics.width, intrinsics.height);
}

} // namespace

Picture render(std::span<const PosedField> layers, const Camera& camera, const DrawOptions& options) {
  constexpr std::size_t kMaxLayers = 255;
  const Intrinsics& intrinsics = camera.intrinsics;
  if (intrinsics.width < 1 || intrinsics.height < 1 || intrinsics.width > kMaxSide || intrinsics.height > kMaxSide) {
    throw Error(ErrorCode::kUsage, "a picture must have between 1 and 16384 pixels on each side");
  }
  if (layers.size() > kMaxLayers) throw Error(ErrorCode::kUsage, "at most 255 layers can be drawn together");
  if (options.quality == DrawQuality::kFast) return render_fast(layers, camera, options);
  std::vector<ProjectedLayer> views;
  for (const PosedField& posed : layers) views.emplace_back(posed, camera);
  int per_side = options.samples;
  if (per_side < 1 || per_side > DrawOptions::kMaxSamples || kTile % per_side != 0) {
    throw Error(ErrorCode::kUsage, "a pixel is drawn with 1, 2, 4 or 8 samples along each side");
  }
  while (per_side * std::max(intrinsics.width, intrinsics.height) > kMaxSide) per_side /= 2;
  const Intrinsics fine = intrinsics.resized(per_side * intrinsics.width, per_side * intrinsics.height);
  std::vector<TriangleBins::Mesh> meshes;
  meshes.reserve(views.size());
  for (const ProjectedLayer& view : views) meshes.push_back({view.corners(), view.faces()});
  const TriangleBins bins(fine, meshes);
  Picture picture{ColorImage(intrinsics.width, intrinsics.height, 4), DepthImage(intrinsics.width, intrinsics.height),
                  LabelImage(intrinsics.width, intrinsics.height)};
  if (options.normals) picture.normal = Image<float>(intrinsics.width, intrinsics.height, 3);
  if (options.confidence) picture.confidence = Image<std::uint8_t>(intrinsics.width, intrinsics.height, 1);
  parallel_for(static_cast<std::size_t>(bins.rows()), 1, [&](const Chunk& row) {
    TileRenderer tile(views, bins, fine, per_side, options, picture);
    for (int column = 0; column < bins.columns(); ++column) tile.draw(column, static_cast<int>(row.begin));
  });
  return picture;
}

} // namespace kinora::fields
