// A picture tile by tile: where rays enter layers, the surfaces behind, their colours, and pixels out of samples.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "fields/rendering/projected_layer.h"
#include "fields/rendering/rasterizer.h"
#include "fields/rendering/renderer.h"
#include "fields/rendering/tile_changes.h"
#include "fields/rendering/tile_marcher.h"
#include "fields/rendering/tile_samples.h"
#include "fields/rendering/tile_shader.h"

namespace kinora::fields {

/// Keeps its buffers from tile to tile. Not thread-safe; several may draw different tiles of one picture.
class TileRenderer {
public:
  /// What it is made from must outlive it. `intrinsics`: of the samples, `per_side`² of which make a pixel. `still`:
  /// for each layer whether `picture` shows it already; empty: there is nothing in it.
  TileRenderer(std::span<const ProjectedLayer> views, const TriangleBins& bins, const Intrinsics& intrinsics,
               int per_side, const DrawOptions& options, std::span<const std::uint8_t> still, Picture& picture);

  void draw(int column, int row);

private:
  bool is_still(std::size_t layer) const { return !still_.empty() && still_[layer] != 0; }
  bool is_left_to_draw(std::span<const std::uint32_t> triangles) const;
  void find_entries(std::span<const std::uint32_t> triangles);
  void find_rays(const TileRays& tile);
  void find_order();
  void find_changes(int columns, int rows);
  void march(bool still);
  void draw_pixels();
  void composite(std::uint32_t p);
  void write(int left, int top);
  void put(int u, int v, const Sample& middle, const Eigen::Array4f& color, float alpha);
  void clear(int u, int v);
  const Sample& middle_sample();

  std::span<const ProjectedLayer> views_;
  const TriangleBins& bins_;
  const Intrinsics& intrinsics_;
  int per_side_;
  const DrawOptions& options_;
  std::span<const std::uint8_t> still_; // per layer, or empty
  Picture& picture_;
  int left_ = 0, top_ = 0;
  PixelRays rays_;
  std::vector<TileMarcher> marchers_;                        // per layer
  std::vector<TileShader> shaders_;                          // per layer
  std::vector<std::pair<float, std::uint32_t>> layer_order_; // depth and number
  Surfaces surfaces_;
  std::vector<std::uint32_t> pixels_; // that are drawn together
  TileChanges changes_;
  TileSamples samples_;
  std::vector<const Sample*> order_; // of a pixel
};

} // namespace kinora::fields
