#include "fields/sampling/pixel_store.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/random.h"
#include "fields/sampling/surface_band.h"
#include "fields/sampling/surface_extension.h"

namespace kinora::fields {
namespace {

constexpr int kReach = 6; // pixels from which a depth is guessed

/// Which pixels have any clean depth within reach: most that have none themselves lie in wide holes.
class Surroundings {
public:
  explicit Surroundings(const DepthImage& clean)
      : width_(clean.width()), rows_(clean.pixel_count()), any_(clean.pixel_count()) {
    const int height = clean.height();
    for (int v = 0; v < height; ++v) {
      mark(
          width_, [&](int u) { return clean.at(u, v) > 0; }, [&](int u) -> char& { return rows_[at(u, v)]; });
    }
    for (int u = 0; u < width_; ++u) {
      mark(
          height, [&](int v) { return rows_[at(u, v)] != 0; }, [&](int v) -> char& { return any_[at(u, v)]; });
    }
  }
  bool have_any(int u, int v) const { return any_[at(u, v)] != 0; }

private:
  // Whether any of a line's places within reach of each is set.
  template <class Set, class Near> static void mark(int count, const Set& set, const Near& near) {
    int last = -2 * kReach - 1; // that was set
    for (int i = 0; i < count + kReach; ++i) {
      if (i < count && set(i)) last = i;
      if (i >= kReach) near(i - kReach) = last >= i - 2 * kReach ? 1 : 0;
    }
  }
  std::size_t at(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(u);
  }

  int width_;
  std::vector<char> rows_, any_;
};

// The depth of a pixel that has no clean one: that of a clean pixel near it with the same label, of these the one that
// agrees best with what was measured, or else the nearest. Between two layers a measurement may lie on neither, but the
// label says whose surface it is. 0 if there is none.
float guessed_depth(const ingest::Frame& frame, int u, int v) {
  const float measured = frame.depth.at(u, v);
  const int label = frame.label_at(u, v);
  float best = 0;
  float min_cost = std::numeric_limits<float>::infinity();
  for (int y = std::max(v - kReach, 0); y <= std::min(v + kReach, frame.depth.height() - 1); ++y) {
    for (int x = std::max(u - kReach, 0); x <= std::min(u + kReach, frame.depth.width() - 1); ++x) {
      const float clean = frame.clean_depth.at(x, y);
      if (!(clean > 0) || frame.label_at(x, y) != label) continue;
      const auto distance = static_cast<float>((x - u) * (x - u) + (y - v) * (y - v));
      const float cost = measured > 0 ? std::abs(clean - measured) : distance;
      if (cost < min_cost) {
        min_cost = cost;
        best = clean;
      }
    }
  }
  return measured > 0 && min_cost <= kSensorNoise.three_sigma(best) ? measured : best;
}

} // namespace

PixelStore::PixelStore(std::size_t max_pixels, std::size_t expected_frames)
    : max_pixels_(max_pixels), expected_frames_(std::max<std::size_t>(expected_frames, 1)),
      pixels_per_frame_(max_pixels / expected_frames_) {}

void PixelStore::add(const ingest::Frame& frame, int timeline_index) {
  const int width = frame.color.width();
  const int height = frame.color.height();
  const std::size_t begin = pixels_.size();
  const std::size_t count = frame.color.pixel_count();
  const std::size_t wanted = std::min(count, pixels_per_frame_);
  make_room(wanted);
  const Surroundings surroundings(frame.clean_depth);
  const DepthImage extended = extend_surfaces(frame, 0, [&](int u, int v) { return !surroundings.have_any(u, v); });
  Random random(0x5EED, static_cast<std::uint64_t>(timeline_index));
  std::size_t remaining = count;
  std::size_t missing = wanted;
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u, --remaining) {
      // Selection sampling (Knuth, TAOCP vol. 2, 3.4.2, algorithm S): exactly `wanted` of them, in order.
      if (missing < remaining &&
          random.uniform_double() * static_cast<double>(remaining) >= static_cast<double>(missing)) {
        continue;
      }
      --missing;
      const float clean = frame.clean_depth.at(u, v);
      const StoredDepth depth = clean > 0                     ? StoredDepth::measured(clean)
                                : surroundings.have_any(u, v) ? StoredDepth::guessed(guessed_depth(frame, u, v))
                                                              : StoredDepth::extended(extended.at(u, v));
      const std::uint8_t* rgb = frame.color.pixel(u, v);
      pixels_.push_back({static_cast<std::uint16_t>(u),
                         static_cast<std::uint16_t>(v),
                         depth,
                         {rgb[0], rgb[1], rgb[2]},
                         frame.label_at(u, v)});
    }
  }
  frames_.push_back({timeline_index, frame.camera, begin, pixels_.size()});
}

void PixelStore::add(const PixelStore& other) {
  make_room(other.pixels_.size());
  for (StoredFrame frame : other.frames_) {
    frame.begin += pixels_.size();
    frame.end += pixels_.size();
    frames_.push_back(frame);
  }
  pixels_.insert(pixels_.end(), other.pixels_.begin(), other.pixels_.end());
}

void PixelStore::make_room(std::size_t count) {
  if (pixels_.size() + count > max_pixels_) {
    throw Error(ErrorCode::kFailure, "more frames arrived than the store of training pixels was made for");
  }
  if (pixels_.empty()) pixels_.reserve(std::min(max_pixels_, count * expected_frames_));
}

void PixelStore::relabel(int from, int to) {
  for (StoredPixel& pixel : pixels_) {
    if (pixel.label == from) pixel.label = static_cast<std::uint8_t>(to);
  }
}

void PixelStore::change_colors(std::size_t frame, const GainTables& tables) {
  for (std::size_t i = frames_[frame].begin; i < frames_[frame].end; ++i) pixels_[i].color = tables(pixels_[i].color);
}

void PixelStore::set_cameras(const std::vector<SE3>& camera_to_world) {
  for (StoredFrame& frame : frames_)
    frame.camera.camera_to_world = camera_to_world[static_cast<std::size_t>(frame.frame)];
}

void PixelStore::set_readout(const std::vector<Twist>& motion) {
  for (StoredFrame& frame : frames_) frame.readout = motion[static_cast<std::size_t>(frame.frame)];
}

PixelStore PixelStore::thinned(const std::vector<std::size_t>& left_out, std::size_t max_pixels) const {
  PixelStore part(max_pixels, frames_.size());
  const double share = static_cast<double>(max_pixels) / static_cast<double>(std::max<std::size_t>(pixels_.size(), 1));
  for (std::size_t f = 0; f < frames_.size(); ++f) {
    if (std::binary_search(left_out.begin(), left_out.end(), f)) continue;
    Random random(0x7217, f);
    const std::size_t begin = part.pixels_.size();
    for (std::size_t i = frames_[f].begin; i < frames_[f].end; ++i) {
      if (random.uniform_double() < share) part.pixels_.push_back(pixels_[i]);
    }
    part.frames_.push_back({frames_[f].frame, frames_[f].camera, begin, part.pixels_.size(), frames_[f].readout});
  }
  return part;
}

} // namespace kinora::fields
