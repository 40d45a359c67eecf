#include "fields/sampling/row_depth.h"

#include <cmath>
#include <utility>

#include "core/parallel.h"
#include "core/row_lookup.h"

namespace kinora::fields {
namespace {

/// A frame's pixels, each where it lies in the picture; one that was not stored is its neighbour.
class StoredPicture {
public:
  StoredPicture(const StoredFrame& frame, const PixelStore& store)
      : pixels_(frame.camera.intrinsics.width, frame.camera.intrinsics.height),
        depth_(frame.camera.intrinsics.width, frame.camera.intrinsics.height) {
    for (std::size_t i = frame.begin; i < frame.end; ++i) {
      const StoredPixel& pixel = store.pixels()[i];
      pixels_.at(pixel.u, pixel.v) = &pixel;
    }
    if (frame.end - frame.begin < pixels_.pixel_count()) fill_gaps();
    for (std::size_t i = 0; i < pixels_.pixel_count(); ++i) {
      if (const StoredPixel* pixel = pixels_.data()[i]) depth_.data()[i] = pixel->depth.metres();
    }
  }

  const DepthImage& depth() const { return depth_; }
  /// Nothing where none was stored near.
  const StoredPixel* at(const Eigen::Vector2d& place) const {
    return pixels_.at(static_cast<int>(std::lround(place.x())), static_cast<int>(std::lround(place.y())));
  }

private:
  void fill_gaps() {
    const Image<const StoredPixel*> stored = pixels_;
    for (int v = 0; v < stored.height(); ++v) {
      for (int u = 0; u < stored.width(); ++u) {
        for (const auto& [du, dv] : {std::pair{0, 0}, {-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
          if (pixels_.at(u, v) == nullptr && stored.contains(u + du, v + dv)) {
            pixels_.at(u, v) = stored.at(u + du, v + dv);
          }
        }
      }
    }
  }

  Image<const StoredPixel*> pixels_;
  DepthImage depth_;
};

} // namespace

void carry_depth_to_rows(PixelStore& store, const std::vector<Twist>& motion) {
  parallel_for(store.frames().size(), 1, [&](const Chunk& chunk) {
    const StoredFrame& frame = store.frames()[chunk.index];
    const StoredPicture picture(frame, store);
    const RowLookup lookup(picture.depth(), frame.camera.intrinsics, motion[static_cast<std::size_t>(frame.frame)]);
    std::vector<StoredDepth> carried;
    carried.reserve(frame.end - frame.begin);
    for (std::size_t i = frame.begin; i < frame.end; ++i) {
      const StoredPixel& pixel = store.pixels()[i];
      const RowLookup::Place place = lookup.place_of(pixel.u, pixel.v);
      const StoredPixel* seen = place.is_found ? picture.at(place.at) : nullptr;
      const bool is_same = seen != nullptr && seen->label == pixel.label;
      carried.push_back(is_same ? seen->depth.at(static_cast<float>(place.depth)) : pixel.depth);
    }
    for (std::size_t i = frame.begin; i < frame.end; ++i) store.change_depth(i, carried[i - frame.begin]);
  });
}

} // namespace kinora::fields
