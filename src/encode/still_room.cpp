#include "encode/still_room.h"

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "core/parallel.h"
#include "core/sensor_noise.h"
#include "core/statistics.h"

namespace kinora::encode {
namespace {

using fields::PixelStore;
using fields::StoredDepth;
using fields::StoredFrame;
using fields::StoredPixel;

constexpr std::size_t kRows = 16; // of pictures, at a time

bool stands_still(const std::vector<StoredFrame>& frames) {
  return std::all_of(frames.begin(), frames.end(), [&](const StoredFrame& frame) {
    const Intrinsics& k = frame.camera.intrinsics;
    const Intrinsics& first = frames.front().camera.intrinsics;
    return frame.camera.camera_to_world.isApprox(frames.front().camera.camera_to_world) && k.width == first.width &&
           k.height == first.height;
  });
}

/// A label that no pixel has.
std::optional<std::uint8_t> unused_label(const PixelStore& pixels) {
  std::array<bool, 256> used{};
  for (const StoredPixel& pixel : pixels.pixels()) used[pixel.label] = true;
  const auto unused = std::find(used.rbegin(), used.rend(), false);
  if (unused == used.rend()) return std::nullopt;
  return static_cast<std::uint8_t>(used.rend() - unused - 1);
}

struct Corrections {
  struct Depth {
    std::uint32_t pixel;
    StoredDepth depth;
  };
  std::vector<std::uint32_t> nobodys;
  std::vector<Depth> moved;
};

/// Where layers that move come near in two frames or more, in blocks of the picture: elsewhere depths differ from time
/// to time, too, along edges of what rests.
class Visited {
public:
  explicit Visited(const PixelStore& pixels) : Visited(pixels, pixels.frames().front().camera.intrinsics) {}

  bool near(const StoredPixel& pixel) const { return farthest_near(pixel) > 0; }
  /// Metres: what of them was measured farthest in or beside the pixel's block, in all frames but one, which may be
  /// noise.
  float farthest_near(const StoredPixel& pixel) const {
    float farthest = 0;
    for (int y = 0; y < 3; ++y) {
      for (int x = 0; x < 3; ++x) {
        farthest = std::max(farthest, blocks_[at(pixel.u / block_ + x, pixel.v / block_ + y)].second);
      }
    }
    return farthest;
  }

private:
  static constexpr int kBlocks = 80; // across a picture

  struct Block {
    float in_frame = 0; // the farthest, as are the others
    float first = 0;
    float second = 0;
  };

  Visited(const PixelStore& pixels, const Intrinsics& camera)
      : block_(std::max(1, camera.width / kBlocks)), columns_(camera.width / block_ + 3),
        blocks_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(camera.height / block_ + 3)) {
    for (const StoredFrame& frame : pixels.frames()) {
      for (std::size_t i = frame.begin; i < frame.end; ++i) {
        const StoredPixel& pixel = pixels.pixels()[i];
        if (pixel.label == 0 || !pixel.depth.is_measured()) continue;
        float& farthest = blocks_[at(pixel.u / block_ + 1, pixel.v / block_ + 1)].in_frame;
        farthest = std::max(farthest, pixel.depth.metres());
      }
      for (Block& block : blocks_) {
        block.second = std::max(block.second, std::min(block.first, block.in_frame));
        block.first = std::max(block.first, block.in_frame);
        block.in_frame = 0;
      }
    }
  }
  std::size_t at(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column);
  }

  int block_; // pixels
  int columns_;
  std::vector<Block> blocks_; // with one more on each side
};

/// One place of the picture in all frames.
class Place {
public:
  Place(const PixelStore& pixels, const Visited& visited) : pixels_(pixels), visited_(visited) {}

  void clear() {
    numbers_.clear();
    room_.clear();
    others_.clear();
  }
  void add(std::uint32_t number) {
    numbers_.push_back(number);
    const StoredPixel& pixel = pixels_.pixels()[number];
    if (pixel.depth.is_measured()) (pixel.label == 0 ? room_ : others_).push_back(pixel.depth.metres());
  }

  void correct(Corrections& corrections) {
    if (numbers_.empty()) return;
    const float room = room_.empty() ? 0 : median(room_);
    const float others = others_.empty() ? 0 : median(others_);
    const float farthest = visited_.farthest_near(pixels_.pixels()[numbers_.front()]);
    const float behind_others = farthest + kOthersSigmas * sigma(farthest) + kBehind;
    for (const std::uint32_t number : numbers_) {
      const StoredPixel& pixel = pixels_.pixels()[number];
      if (pixel.label != 0 || !pixel.depth.is_known()) continue;
      const float depth = pixel.depth.metres();
      if (pixel.depth.is_extended()) {
        const float back = std::max(room_.size() > 1 ? room : 0, behind_others);
        if (back > depth) corrections.moved.push_back({number, StoredDepth::extended(back)});
        continue;
      }
      const bool before_room = room_.size() > 2 && depth < room - kRoomSigmas * sigma(room) - kThickness;
      const bool before_others = others_.size() > 2 && depth < others - kOthersSigmas * sigma(others);
      if (before_room || before_others) corrections.nobodys.push_back(number);
    }
  }

private:
  static constexpr float kRoomSigmas = 8;
  static constexpr float kThickness = 0.02F; // metres: what stands before a room is no thinner
  static constexpr float kOthersSigmas = kThreeSigmaOfDifference;
  static constexpr float kBehind = 0.05F; // metres: fields are taught within 2 to 4 cm of a guess

  static float sigma(float depth) { return static_cast<float>(kSensorNoise.sigma(depth)); }

  const PixelStore& pixels_;
  const Visited& visited_;
  std::vector<std::uint32_t> numbers_;
  std::vector<float> room_, others_; // measured
};

// Of some rows of the picture.
Corrections corrections_of(const PixelStore& pixels, const Visited& visited, std::size_t first_row, std::size_t end_row,
                           std::size_t width) {
  std::vector<std::vector<std::uint32_t>> at((end_row - first_row) * width);
  for (const StoredFrame& frame : pixels.frames()) {
    const auto begin = pixels.pixels().begin() + static_cast<std::ptrdiff_t>(frame.begin);
    const auto end = pixels.pixels().begin() + static_cast<std::ptrdiff_t>(frame.end);
    const auto before = [](const StoredPixel& pixel, std::size_t row) { return pixel.v < row; };
    auto pixel = std::lower_bound(begin, end, first_row, before);
    for (; pixel != end && pixel->v < end_row; ++pixel) {
      if (!visited.near(*pixel)) continue;
      at[(pixel->v - first_row) * width + pixel->u].push_back(
          static_cast<std::uint32_t>(pixel - pixels.pixels().begin()));
    }
  }
  Corrections corrections;
  Place place(pixels, visited);
  for (const std::vector<std::uint32_t>& numbers : at) {
    place.clear();
    for (const std::uint32_t number : numbers) place.add(number);
    place.correct(corrections);
  }
  return corrections;
}

} // namespace

void correct_still_room(PixelStore& pixels) {
  if (pixels.frames().empty() || !stands_still(pixels.frames())) return;
  const Intrinsics& camera = pixels.frames().front().camera.intrinsics;
  const auto width = static_cast<std::size_t>(camera.width);
  const auto height = static_cast<std::size_t>(camera.height);
  const std::optional<std::uint8_t> nobody = unused_label(pixels);
  const Visited visited(pixels);
  std::vector<Corrections> parts(chunk_count(height, kRows));
  parallel_for(height, kRows, [&](const Chunk& rows) {
    parts[rows.index] = corrections_of(pixels, visited, rows.begin, rows.end, width);
  });
  for (const Corrections& part : parts) {
    for (const Corrections::Depth& moved : part.moved) pixels.change_depth(moved.pixel, moved.depth);
    if (!nobody) continue;
    for (const std::uint32_t pixel : part.nobodys) pixels.change_label(pixel, *nobody);
  }
}

} // namespace kinora::encode
