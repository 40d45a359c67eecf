#include "fields/rendering/tile_renderer.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kinora::fields {
namespace {

constexpr int kTile = TriangleBins::kTile;

float shown(const Sample& sample) { return sample.color[3] > 1 - 2 * kOpaque ? 1.0F : sample.color[3]; }

// What is not met is farthest; the more opaque is before it.
bool is_nearer(const Sample* a, const Sample* b) {
  if (a->depth > 0 && b->depth > 0) return a->depth < b->depth;
  return a->depth > 0 || (!(b->depth > 0) && a->max_share > b->max_share);
}

std::uint8_t to_byte(float value) {
  return static_cast<std::uint8_t>(std::lrint(255.0F * std::clamp(value, 0.0F, 1.0F)));
}

} // namespace

TileRenderer::TileRenderer(std::span<const ProjectedLayer> views, const TriangleBins& bins,
                           const Intrinsics& intrinsics, int per_side, const DrawOptions& options,
                           std::span<const std::uint8_t> still, Picture& picture)
    : views_(views), bins_(bins), intrinsics_(intrinsics), per_side_(per_side), options_(options), still_(still),
      picture_(picture) {
  for (const ProjectedLayer& view : views) {
    marchers_.emplace_back(view, static_cast<std::uint32_t>(marchers_.size()), bins);
    shaders_.emplace_back(view.layer());
  }
}

void TileRenderer::draw(int column, int row) {
  left_ = column * kTile;
  top_ = row * kTile;
  const std::span<const std::uint32_t> triangles = bins_.of_tile(column, row);
  if (!is_left_to_draw(triangles)) return;
  find_entries(triangles);
  find_order();
  surfaces_.clear();
  for (TileMarcher& marcher : marchers_) marcher.begin_tile();
  const int columns = std::min(kTile, intrinsics_.width - left_);
  const int rows = std::min(kTile, intrinsics_.height - top_);
  find_changes(columns, rows);
  samples_.clear();
  for (const bool between : {false, true}) {
    pixels_.clear();
    for (int v = 0; v < rows; ++v) {
      for (int u = (v + (between ? 1 : 0)) % 2; u < columns; u += 2) {
        const auto p = static_cast<std::uint32_t>(v * kTile + u);
        if (!changes_.needed(p)) continue;
        if (!between || !samples_.fill(p)) pixels_.push_back(p);
      }
    }
    draw_pixels();
  }
  for (int v = 0; v < kTile; v += per_side_) {
    for (int u = 0; u < kTile; u += per_side_) {
      const int sample = v * kTile + u;
      if (changes_.changed(static_cast<std::size_t>(sample))) write(u, v);
    }
  }
}

void TileRenderer::find_rays(const TileRays& tile) {
  auto* next = rays_.data();
  for (int row = 0; row < kTile; ++row) {
    for (int column = 0; column < kTile; ++column) {
      const Eigen::Vector3f ray(tile.x + static_cast<float>(column) * tile.dx,
                                tile.y + static_cast<float>(row) * tile.dy, 1);
      *next++ = {ray, 1 / ray.norm()};
    }
  }
}

// Whether a layer that the picture does not show yet may have something here.
bool TileRenderer::is_left_to_draw(std::span<const std::uint32_t> triangles) const {
  for (std::size_t l = 0; l < views_.size(); ++l) {
    if (views_[l].contains_camera() && !is_still(l)) return true;
  }
  return std::any_of(triangles.begin(), triangles.end(),
                     [&](std::uint32_t triangle) { return !is_still(bins_.triangle(triangle).layer); });
}

// What moves is marched to here; a pixel that meets nothing of it shows what it showed.
void TileRenderer::find_changes(int columns, int rows) {
  if (still_.empty()) return changes_.set_all();
  pixels_.clear();
  for (int v = 0; v < rows; ++v) {
    for (int u = 0; u < columns; ++u) pixels_.push_back(static_cast<std::uint32_t>(v * kTile + u));
  }
  march(false);
  TileChanges::Samples touched{};
  for (const std::uint32_t p : pixels_) {
    if (surfaces_.count(p) > 0) touched[p / kTile] |= static_cast<std::uint16_t>(1U << p % kTile);
  }
  changes_.find(touched, per_side_);
}

// Of `pixels_`, from near to far, to the layers that are `still` or to the others.
void TileRenderer::march(bool still) {
  const bool only_visible = options_.unseen == Unseen::kKeep; // what fades hides nothing
  for (const auto& [depth, l] : layer_order_) {
    if (is_still(l) == still) marchers_[l].march(rays_, pixels_, only_visible, surfaces_);
  }
}

void TileRenderer::find_entries(std::span<const std::uint32_t> triangles) {
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
}

// The layers from near to far, by where a ray first enters them.
void TileRenderer::find_order() {
  layer_order_.clear();
  for (std::uint32_t l = 0; l < marchers_.size(); ++l) {
    const Entries& entries = marchers_[l].entries();
    float nearest = std::numeric_limits<float>::infinity();
    for (std::size_t p = 0; p < Entries::kPixels; ++p) {
      if (entries.count(p) > 0) nearest = std::min(nearest, entries.at(p, 0).depth);
    }
    layer_order_.emplace_back(nearest, l);
  }
  std::sort(layer_order_.begin(), layer_order_.end());
}

void TileRenderer::draw_pixels() {
  march(!still_.empty());
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
void TileRenderer::composite(std::uint32_t p) {
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
void TileRenderer::write(int left, int top) {
  const int first = top * kTile + left;
  if (per_side_ == 1) {
    const Sample& sample = samples_[static_cast<std::size_t>(first)];
    return put(left_ + left, top_ + top, sample, sample.color, shown(sample));
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
  Sample middle = middle_sample();
  if (const float length = normal.norm(); length > 1e-6F) middle.normal = normal / length;
  middle.confidence = confidence;
  put((left_ + left) / per_side_, (top_ + top) / per_side_, middle, color,
      drawn / static_cast<float>(per_side_ * per_side_));
}

// `color` and the confidence of `middle`: times opacity, of all the pixel's samples.
void TileRenderer::put(int u, int v, const Sample& middle, const Eigen::Array4f& color, float alpha) {
  if (!picture_.color.contains(u, v)) return;
  if (!still_.empty()) clear(u, v);
  if (!(color[3] > 0)) return;
  Eigen::Array4f straight = color / color[3];
  straight[3] = alpha;
  const Eigen::Array4i bytes = (255 * straight.max(0).min(1) + 0.5F).cast<int>();
  std::copy_n(bytes.data(), 4, picture_.color.pixel(u, v));
  picture_.depth.at(u, v) = middle.depth;
  picture_.front.at(u, v) = middle.front;
  if (options_.normals && middle.depth > 0) std::copy_n(middle.normal.data(), 3, picture_.normal.pixel(u, v));
  if (options_.confidence && middle.depth > 0) picture_.confidence.at(u, v) = to_byte(middle.confidence / color[3]);
}

void TileRenderer::clear(int u, int v) {
  std::fill_n(picture_.color.pixel(u, v), 4, std::uint8_t{0});
  picture_.depth.at(u, v) = 0;
  picture_.front.at(u, v) = 0;
  if (options_.normals) std::fill_n(picture_.normal.pixel(u, v), 3, 0.0F);
  if (options_.confidence) picture_.confidence.at(u, v) = 0;
}

// Of order_, from near to far.
const Sample& TileRenderer::middle_sample() {
  const auto middle = order_.begin() + static_cast<std::ptrdiff_t>(order_.size() / 2);
  std::nth_element(order_.begin(), middle, order_.end(), is_nearer);
  return **middle;
}

} // namespace kinora::fields
