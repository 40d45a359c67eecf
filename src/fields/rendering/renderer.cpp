#include "fields/rendering/renderer.h"

#include <algorithm>

#include "core/error.h"
#include "core/parallel.h"
#include "fields/rendering/projected_layer.h"
#include "fields/rendering/tile_renderer.h"
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
  if (graph != nullptr) {
    derived->proxy_mesh.bind_to(*graph);
  } else {
    derived->proxy_mesh.forget_cells();
  }
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

constexpr int kMaxSide = 16384;
static_assert(TriangleBins::kTile % DrawOptions::kMaxSamples == 0);

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

Picture empty_picture(const Intrinsics& intrinsics, const DrawOptions& options) {
  Picture picture{ColorImage(intrinsics.width, intrinsics.height, 4), DepthImage(intrinsics.width, intrinsics.height),
                  LabelImage(intrinsics.width, intrinsics.height)};
  if (options.normals) picture.normal = Image<float>(intrinsics.width, intrinsics.height, 3);
  if (options.confidence) picture.confidence = Image<std::uint8_t>(intrinsics.width, intrinsics.height, 1);
  return picture;
}

// With the numbers that its layers have among all.
Picture copy_of(const Backdrop& backdrop) {
  Picture picture = *backdrop.picture;
  for (std::uint8_t& front : picture.front.values()) {
    if (front > 0) front = static_cast<std::uint8_t>(backdrop.layers.at(front - 1U) + 1);
  }
  return picture;
}

} // namespace

Picture render(std::span<const PosedField> layers, const Camera& camera, const DrawOptions& options,
               const Backdrop* backdrop) {
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
  if (per_side < 1 || per_side > DrawOptions::kMaxSamples || TriangleBins::kTile % per_side != 0) {
    throw Error(ErrorCode::kUsage, "a pixel is drawn with 1, 2, 4 or 8 samples along each side");
  }
  while (per_side * std::max(intrinsics.width, intrinsics.height) > kMaxSide) per_side /= 2;
  const Intrinsics fine = intrinsics.resized(per_side * intrinsics.width, per_side * intrinsics.height);
  std::vector<TriangleBins::Mesh> meshes;
  meshes.reserve(views.size());
  for (const ProjectedLayer& view : views) meshes.push_back({view.corners(), view.faces()});
  const TriangleBins bins(fine, meshes);
  Picture picture = backdrop != nullptr ? copy_of(*backdrop) : empty_picture(intrinsics, options);
  std::vector<std::uint8_t> still(backdrop != nullptr ? layers.size() : 0);
  if (backdrop != nullptr) {
    for (const std::uint8_t layer : backdrop->layers) still.at(layer) = 1;
  }
  parallel_for(static_cast<std::size_t>(bins.rows()), 1, [&](const Chunk& row) {
    TileRenderer tile(views, bins, fine, per_side, options, still, picture);
    for (int column = 0; column < bins.columns(); ++column) tile.draw(column, static_cast<int>(row.begin));
  });
  return picture;
}

} // namespace kinora::fields
