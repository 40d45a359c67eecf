#include "fields/sampling/surface_extension.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <utility>
#include <vector>

#include "core/sensor_noise.h"

namespace kinora::fields {
namespace {

/// Inverse depth about a place, 1/m and 1/m per pixel: a plane of space is linear in it.
struct Plane {
  float value = 0; ///< at the place; 0: none
  float per_u = 0;
  float per_v = 0;

  float at(float du, float dv) const { return value + per_u * du + per_v * dv; } ///< pixels from the place
};

constexpr std::array<std::array<int, 2>, 8> kNeighbours = {
    {{-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {1, -1}, {-1, 1}, {1, 1}}};

/// Of one frame; used once. What goes on are cells: squares of as many pixels as make a picture of about kCellsPerSide.
class Extension {
public:
  Extension(const ingest::Frame& frame, std::uint8_t label, const std::function<bool(int, int)>& is_wanted)
      : frame_(frame), label_(label),
        size_(std::max({1, frame.color.width() / kCellsPerSide, frame.color.height() / kCellsPerSide})),
        width_((frame.color.width() + size_ - 1) / size_), height_((frame.color.height() + size_ - 1) / size_),
        radius_(std::max(3, frame.color.width() / kWindowsPerWidth)), cells_(width_, height_) {
    look(is_wanted);
  }

  DepthImage depths() {
    DepthImage guessed(frame_.color.width(), frame_.color.height());
    if (!has_hole_ || !find_range()) return guessed;
    smooth_ = smoothed(frame_.color);
    planes_.resize(cells_.pixel_count());
    costs_.assign(cells_.pixel_count(), kNotReached);
    begin_at_surfaces();
    // No step is shorter than a pixel: what is reached from these cells comes in later turns (Dial, CACM 12(11), 1969).
    for (std::size_t turn = 0; turn < front_.size(); ++turn) {
      std::vector<Reached> reached = std::move(front_[turn]);
      std::ranges::sort(reached);
      for (const auto& [cost, at] : reached) {
        if (cells_.data()[at] != Cell::kHole) continue; // by a shorter way
        settle(at);
        write(at, guessed);
        go_on_from(at, cost);
      }
    }
    return guessed;
  }

private:
  static constexpr int kCellsPerSide = 320;
  static constexpr int kWindowsPerWidth = 40; // a plane is fitted to a window that reaches so far to each side
  static constexpr float kPathPerColor = 30;  // pixels of way that a change from black to white is worth
  static constexpr float kSameSurface = 0.1F; // relative difference of depths in a window
  static constexpr float kSamePlane = 0.02F;  // and from the plane through them
  static constexpr float kSameGuess = 0.05F;  // and of what neighbours say
  static constexpr float kBeyondRange = 2;    // factor from the nearest and the farthest depth
  static constexpr float kNotReached = 1e30F;

  enum class Cell : std::uint8_t {
    kOther,    ///< has no pixel of the label
    kMeasured, ///< has a clean depth
    kMissing,  ///< has none, and nothing in its hole is wanted
    kHole,     ///< has none yet
    kSettled,  ///< by a guess, or measured beside a hole
  };

  std::size_t index(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(u);
  }
  bool is_measured(int u, int v) const { return frame_.clean_depth.at(u, v) > 0 && frame_.label_at(u, v) == label_; }
  bool is_missing(int u, int v) const { return !(frame_.clean_depth.at(u, v) > 0) && frame_.label_at(u, v) == label_; }

  /// Calls with each pixel of a cell.
  template <class Function> void for_pixels(int cell_u, int cell_v, const Function& function) const {
    const int right = std::min((cell_u + 1) * size_, frame_.color.width());
    const int bottom = std::min((cell_v + 1) * size_, frame_.color.height());
    for (int v = cell_v * size_; v < bottom; ++v) {
      for (int u = cell_u * size_; u < right; ++u) function(u, v);
    }
  }
  float middle() const { return 0.5F * static_cast<float>(size_ - 1); } ///< of a cell, pixels from its first one

  // Holes are those with a pixel that is wanted: most are a few pixels wide, and none of theirs is.
  void look(const std::function<bool(int, int)>& is_wanted) {
    std::vector<std::size_t> wanted;
    for (int v = 0; v < height_; ++v) {
      for (int u = 0; u < width_; ++u) {
        bool measured = false, missing = false, is_asked = false;
        for_pixels(u, v, [&](int x, int y) {
          if (is_measured(x, y)) measured = true;
          if (!is_missing(x, y)) return;
          missing = true;
          is_asked = is_asked || is_wanted(x, y);
        });
        cells_.at(u, v) = measured ? Cell::kMeasured : missing ? Cell::kMissing : Cell::kOther;
        if (is_asked && !measured) wanted.push_back(index(u, v));
      }
    }
    has_hole_ = !wanted.empty();
    for (const std::size_t from : wanted) fill(from);
  }

  void fill(std::size_t from) {
    if (cells_.data()[from] != Cell::kMissing) return;
    cells_.data()[from] = Cell::kHole;
    std::vector<std::size_t> front = {from};
    while (!front.empty()) {
      const std::size_t at = front.back();
      front.pop_back();
      for_neighbours(at, [&](std::size_t next, const auto& /*step*/) {
        if (cells_.data()[next] != Cell::kMissing) return;
        cells_.data()[next] = Cell::kHole;
        front.push_back(next);
      });
    }
  }

  /// Calls with the number of each cell beside one, and the step there.
  template <class Function> void for_neighbours(std::size_t at, const Function& function) const {
    const int u = static_cast<int>(at % static_cast<std::size_t>(width_));
    const int v = static_cast<int>(at / static_cast<std::size_t>(width_));
    for (const auto& step : kNeighbours) {
      if (cells_.contains(u + step[0], v + step[1])) function(index(u + step[0], v + step[1]), step);
    }
  }

  /// Means of the pixels of a cell, of at least 3×3: a sensor's noise is no edge.
  ColorImage smoothed(const ColorImage& color) const {
    const int width = color.width(), height = color.height();
    const int beyond = size_ < 3 ? 1 : 0; // pixels on each side
    ColorImage out(width_, height_, 3);
    std::vector<int> columns(3 * static_cast<std::size_t>(width)); // sums of a cell's rows
    for (int v = 0; v < height_; ++v) {
      const int top = std::max(v * size_ - beyond, 0), bottom = std::min((v + 1) * size_ + beyond, height);
      std::ranges::fill(columns, 0);
      for (int y = top; y < bottom; ++y) {
        const std::uint8_t* row = color.pixel(0, y);
        for (std::size_t i = 0; i < columns.size(); ++i) columns[i] += row[i];
      }
      for (int u = 0; u < width_; ++u) {
        const int left = std::max(u * size_ - beyond, 0), right = std::min((u + 1) * size_ + beyond, width);
        const int count = (right - left) * (bottom - top);
        for (std::size_t c = 0; c < 3; ++c) {
          int sum = 0;
          for (int x = left; x < right; ++x) sum += columns[3 * static_cast<std::size_t>(x) + c];
          out.pixel(u, v)[c] = static_cast<std::uint8_t>(sum / count);
        }
      }
    }
    return out;
  }

  // What inverse depths are guessed at all; false if there is nothing to guess from.
  bool find_range() {
    std::vector<float> values;
    for (int v = 0; v < frame_.color.height(); v += size_) {
      for (int u = 0; u < frame_.color.width(); u += size_) {
        if (is_measured(u, v)) values.push_back(1 / frame_.clean_depth.at(u, v));
      }
    }
    if (values.empty()) return false;
    const std::size_t outliers = values.size() / 200;
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(outliers), values.end());
    min_value_ = values[outliers] / kBeyondRange;
    const std::size_t last = values.size() - 1 - outliers;
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(last), values.end());
    max_value_ = values[last] * kBeyondRange;
    return true;
  }

  void begin_at_surfaces() {
    std::vector<std::size_t> edge;
    for (int v = 0; v < height_; ++v) {
      for (int u = 0; u < width_; ++u) {
        const std::size_t at = index(u, v);
        if (cells_.data()[at] != Cell::kMeasured) continue;
        bool is_beside_hole = false;
        for_neighbours(at, [&](std::size_t next, const auto& /*step*/) {
          is_beside_hole = is_beside_hole || cells_.data()[next] == Cell::kHole;
        });
        if (!is_beside_hole) continue;
        planes_[at] = plane_of_cell(u, v);
        costs_[at] = 0;
        edge.push_back(at);
      }
    }
    for (const std::size_t at : edge) cells_.data()[at] = Cell::kSettled;
    for (const std::size_t at : edge) go_on_from(at, 0);
  }

  /// Through the first of its measured pixels, at its middle.
  Plane plane_of_cell(int cell_u, int cell_v) const {
    int first_u = -1, first_v = -1;
    for_pixels(cell_u, cell_v, [&](int u, int v) {
      if (first_u < 0 && is_measured(u, v)) first_u = u, first_v = v;
    });
    Plane plane = plane_at(first_u, first_v);
    plane.value = plane.at(static_cast<float>(cell_u * size_ - first_u) + middle(),
                           static_cast<float>(cell_v * size_ - first_v) + middle());
    return plane;
  }

  /// That of the surface around a measured pixel, as far as it hangs together.
  Plane plane_at(int u, int v) const {
    const float middle = 1 / frame_.clean_depth.at(u, v);
    const auto noise = static_cast<float>(kSensorNoise.three_sigma(1 / middle)) * middle * middle;
    const int stride = std::max(1, radius_ / 4);
    Plane plane{middle, 0, 0};
    for (const float tolerance : {kSameSurface * middle, std::max(kSamePlane * middle, noise)}) {
      // About the middle, with slopes held to none as by one reading at a pixel's distance.
      Eigen::Matrix3f sums = Eigen::Vector3f(0, 1, 1).asDiagonal();
      Eigen::Vector3f values = Eigen::Vector3f::Zero();
      for (int dv = -radius_; dv <= radius_; dv += stride) {
        for (int du = -radius_; du <= radius_; du += stride) {
          if (!frame_.color.contains(u + du, v + dv) || !is_measured(u + du, v + dv)) continue;
          const float value = 1 / frame_.clean_depth.at(u + du, v + dv);
          const Eigen::Vector3f place(1, static_cast<float>(du), static_cast<float>(dv));
          if (std::abs(value - Eigen::Vector3f(plane.value, plane.per_u, plane.per_v).dot(place)) > tolerance) continue;
          sums += place * place.transpose();
          values += value * place;
        }
      }
      if (!(sums(0, 0) > 0)) return {middle, 0, 0};
      const Eigen::Vector3f solved = sums.ldlt().solve(values);
      if (!solved.allFinite()) return {middle, 0, 0};
      plane = {solved[0], solved[1], solved[2]};
    }
    return plane;
  }

  /// The largest of the channels'.
  std::size_t color_change(std::size_t a, std::size_t b) const {
    int most = 0;
    for (std::size_t c = 0; c < 3; ++c)
      most = std::max(most, std::abs(smooth_.data()[3 * a + c] - smooth_.data()[3 * b + c]));
    return static_cast<std::size_t>(most);
  }

  struct ColorChange {
    float way;    ///< pixels that it is worth
    float weight; ///< of what is told across it
  };
  static std::array<ColorChange, 256> color_changes() {
    std::array<ColorChange, 256> changes{};
    for (std::size_t i = 0; i < changes.size(); ++i) {
      const float change = static_cast<float>(i) / 255.0F;
      changes[i] = {kPathPerColor * change, std::exp(-kPathPerColor * change)};
    }
    return changes;
  }

  void go_on_from(std::size_t from, float cost) {
    for_neighbours(from, [&](std::size_t to, const auto& step) {
      if (cells_.data()[to] != Cell::kHole) return;
      const float length = static_cast<float>(size_) + changes_[color_change(from, to)].way;
      const float there = cost + length * (step[0] != 0 && step[1] != 0 ? 1.41421356F : 1.0F);
      if (there >= costs_[to]) return;
      costs_[to] = there;
      const auto turn = static_cast<std::size_t>(there);
      if (turn >= front_.size()) front_.resize(turn + 1);
      front_[turn].emplace_back(there, static_cast<std::uint32_t>(to));
    });
  }

  // From its settled neighbours: the one on the shortest way, and those that say nearly the same.
  void settle(std::size_t at) {
    struct Told {
      Plane plane;
      float weight;
    };
    std::array<Told, kNeighbours.size()> told;
    std::size_t count = 0, first = 0;
    float least = kNotReached;
    for_neighbours(at, [&](std::size_t from, const auto& step) {
      if (cells_.data()[from] != Cell::kSettled) return;
      Plane plane = planes_[from];
      plane.value = plane.at(static_cast<float>(-step[0] * size_), static_cast<float>(-step[1] * size_));
      const ColorChange& change = changes_[color_change(from, at)];
      const float way = costs_[from] + static_cast<float>(size_) + change.way;
      if (way < least) {
        least = way;
        first = count;
      }
      told[count++] = {plane, change.weight};
    });
    Plane sum;
    float weights = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const float difference = std::abs(told[i].plane.value - told[first].plane.value);
      if (i != first && difference > kSameGuess * told[first].plane.value) continue;
      const float weight = told[i].weight;
      sum.value += weight * told[i].plane.value;
      sum.per_u += weight * told[i].plane.per_u;
      sum.per_v += weight * told[i].plane.per_v;
      weights += weight;
    }
    const float value = sum.value / weights;
    planes_[at] = {std::clamp(value, min_value_, max_value_), sum.per_u / weights, sum.per_v / weights};
    cells_.data()[at] = Cell::kSettled;
  }

  /// The depths of a cell's pixels.
  void write(std::size_t at, DepthImage& guessed) const {
    const int cell_u = static_cast<int>(at % static_cast<std::size_t>(width_));
    const int cell_v = static_cast<int>(at / static_cast<std::size_t>(width_));
    for_pixels(cell_u, cell_v, [&](int u, int v) {
      if (!is_missing(u, v)) return;
      const float value = planes_[at].at(static_cast<float>(u - cell_u * size_) - middle(),
                                         static_cast<float>(v - cell_v * size_) - middle());
      guessed.at(u, v) = 1 / std::clamp(value, min_value_, max_value_);
    });
  }

  const ingest::Frame& frame_;
  std::uint8_t label_;
  int size_;           ///< of a cell, pixels
  int width_, height_; ///< cells
  int radius_;         ///< pixels
  Image<Cell> cells_;
  bool has_hole_ = false;
  ColorImage smooth_;                              ///< a pixel for each cell
  std::vector<Plane> planes_;                      ///< about the middles of cells
  std::vector<float> costs_;                       ///< lengths of the shortest ways so far, pixels
  using Reached = std::pair<float, std::uint32_t>; ///< by how long a way, and which cell
  std::vector<std::vector<Reached>> front_;        ///< by whole pixels of way
  float min_value_ = 0, max_value_ = 0;
  std::array<ColorChange, 256> changes_ = color_changes(); ///< by differences of bytes
};

} // namespace

DepthImage extend_surfaces(const ingest::Frame& frame, std::uint8_t label,
                           const std::function<bool(int, int)>& is_wanted) {
  return Extension(frame, label, is_wanted).depths();
}

} // namespace kinora::fields
