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

/// Inverse depth about a pixel, 1/m and 1/m per pixel: a plane of space is linear in it.
struct Plane {
  float value = 0; ///< at the pixel; 0: none
  float per_u = 0;
  float per_v = 0;
};

constexpr std::array<std::array<int, 2>, 8> kNeighbours = {
    {{-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {1, -1}, {-1, 1}, {1, 1}}};

/// Of one frame; used once.
class Extension {
public:
  Extension(const ingest::Frame& frame, std::uint8_t label, const std::function<bool(int, int)>& is_wanted)
      : frame_(frame), label_(label), width_(frame.color.width()), height_(frame.color.height()),
        radius_(std::max(3, width_ / kWindowsPerWidth)), holes_(frame.color.pixel_count()) {
    find_holes(is_wanted);
  }

  DepthImage depths() {
    DepthImage guessed(width_, height_);
    if (!has_hole_ || !find_range()) return guessed;
    smooth_ = smoothed(frame_.color);
    planes_.resize(holes_.size());
    costs_.assign(holes_.size(), kNotReached);
    begin_at_surfaces();
    // No step is shorter than a pixel: what is reached from these pixels comes in later turns (Dial, CACM 12(11),
    // 1969).
    for (std::size_t turn = 0; turn < front_.size(); ++turn) {
      std::vector<Reached> reached = std::move(front_[turn]);
      std::ranges::sort(reached);
      for (const auto& [cost, at] : reached) {
        if (settled_[at]) continue; // by a shorter way
        settle(at);
        guessed.data()[at] = 1 / planes_[at].value;
        go_on_from(at, cost);
      }
    }
    return guessed;
  }

private:
  static constexpr int kWindowsPerWidth = 40; // a plane is fitted to a window that reaches so far to each side
  static constexpr float kPathPerColor = 30;  // pixels of way that a change from black to white is worth
  static constexpr float kSameSurface = 0.1F; // relative difference of depths in a window
  static constexpr float kSamePlane = 0.02F;  // and from the plane through them
  static constexpr float kSameGuess = 0.05F;  // and of what neighbours say
  static constexpr float kBeyondRange = 2;    // factor from the nearest and the farthest depth
  static constexpr float kNotReached = 1e30F;

  std::size_t index(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(u);
  }
  bool is_measured(int u, int v) const { return frame_.clean_depth.at(u, v) > 0 && frame_.label_at(u, v) == label_; }
  bool is_hole(int u, int v) const { return holes_[index(u, v)] != 0; }

  // Those with a pixel that is wanted: most holes are a few pixels wide, and none of theirs is.
  void find_holes(const std::function<bool(int, int)>& is_wanted) {
    const auto is_missing = [&](int u, int v) {
      return !(frame_.clean_depth.at(u, v) > 0) && frame_.label_at(u, v) == label_;
    };
    std::vector<std::pair<int, int>> front;
    for (int v = 0; v < height_; ++v) {
      for (int u = 0; u < width_; ++u) {
        if (is_hole(u, v) || !is_missing(u, v) || !is_wanted(u, v)) continue;
        holes_[index(u, v)] = 1;
        front.emplace_back(u, v);
        while (!front.empty()) {
          const auto [x, y] = front.back();
          front.pop_back();
          for (const auto& step : kNeighbours) {
            const int next_x = x + step[0], next_y = y + step[1];
            if (!frame_.color.contains(next_x, next_y) || is_hole(next_x, next_y) || !is_missing(next_x, next_y))
              continue;
            holes_[index(next_x, next_y)] = 1;
            front.emplace_back(next_x, next_y);
          }
        }
        has_hole_ = true;
      }
    }
  }

  /// Means of 3×3 pixels: a sensor's noise is no edge.
  static ColorImage smoothed(const ColorImage& color) {
    const int width = color.width(), height = color.height();
    ColorImage out(width, height, 3);
    std::vector<int> columns(3 * static_cast<std::size_t>(width)); // sums of up to three rows
    for (int v = 0; v < height; ++v) {
      const int top = std::max(v - 1, 0), bottom = std::min(v + 1, height - 1);
      std::ranges::fill(columns, 0);
      for (int y = top; y <= bottom; ++y) {
        const std::uint8_t* row = color.pixel(0, y);
        for (std::size_t i = 0; i < columns.size(); ++i) columns[i] += row[i];
      }
      for (int u = 0; u < width; ++u) {
        const int left = std::max(u - 1, 0), right = std::min(u + 1, width - 1);
        const int count = (right - left + 1) * (bottom - top + 1);
        for (std::size_t c = 0; c < 3; ++c) {
          int sum = 0;
          for (int x = left; x <= right; ++x) sum += columns[3 * static_cast<std::size_t>(x) + c];
          out.pixel(u, v)[c] = static_cast<std::uint8_t>(sum / count);
        }
      }
    }
    return out;
  }

  // What inverse depths are guessed at all; false if there is nothing to guess from.
  bool find_range() {
    std::vector<float> values;
    for (int v = 0; v < height_; ++v) {
      for (int u = 0; u < width_; ++u) {
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
    settled_.assign(planes_.size(), false);
    std::vector<std::size_t> edge;
    for (int v = 0; v < height_; ++v) {
      for (int u = 0; u < width_; ++u) {
        if (!is_measured(u, v)) continue;
        const bool is_beside_hole = std::any_of(kNeighbours.begin(), kNeighbours.end(), [&](const auto& step) {
          return frame_.color.contains(u + step[0], v + step[1]) && is_hole(u + step[0], v + step[1]);
        });
        if (!is_beside_hole) continue;
        const std::size_t at = index(u, v);
        planes_[at] = plane_at(u, v);
        settled_[at] = true;
        costs_[at] = 0;
        edge.push_back(at);
      }
    }
    for (const std::size_t at : edge) go_on_from(at, 0);
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
    const int u = static_cast<int>(from % static_cast<std::size_t>(width_));
    const int v = static_cast<int>(from / static_cast<std::size_t>(width_));
    for (const auto& step : kNeighbours) {
      const int x = u + step[0], y = v + step[1];
      if (!frame_.color.contains(x, y) || !is_hole(x, y)) continue;
      const std::size_t to = index(x, y);
      if (settled_[to]) continue;
      const float length = step[0] != 0 && step[1] != 0 ? 1.41421356F : 1.0F;
      const float there = cost + length * (1 + changes_[color_change(from, to)].way);
      if (there >= costs_[to]) continue;
      costs_[to] = there;
      const auto turn = static_cast<std::size_t>(there);
      if (turn >= front_.size()) front_.resize(turn + 1);
      front_[turn].emplace_back(there, static_cast<std::uint32_t>(to));
    }
  }

  // From its settled neighbours: the one on the shortest way, and those that say nearly the same.
  void settle(std::size_t at) {
    const int u = static_cast<int>(at % static_cast<std::size_t>(width_));
    const int v = static_cast<int>(at / static_cast<std::size_t>(width_));
    struct Told {
      Plane plane;
      float weight;
    };
    std::array<Told, kNeighbours.size()> told;
    std::size_t count = 0, first = 0;
    float least = kNotReached;
    for (const auto& step : kNeighbours) {
      const int x = u + step[0], y = v + step[1];
      if (!frame_.color.contains(x, y)) continue;
      const std::size_t from = index(x, y);
      if (!settled_[from]) continue;
      Plane plane = planes_[from];
      plane.value -= plane.per_u * static_cast<float>(step[0]) + plane.per_v * static_cast<float>(step[1]);
      const ColorChange& change = changes_[color_change(from, at)];
      const float way = costs_[from] + 1 + change.way;
      if (way < least) {
        least = way;
        first = count;
      }
      told[count++] = {plane, change.weight};
    }
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
    settled_[at] = true;
  }

  const ingest::Frame& frame_;
  std::uint8_t label_;
  int width_, height_;
  int radius_;
  std::vector<char> holes_; ///< of each pixel: whether it is to be guessed
  bool has_hole_ = false;
  ColorImage smooth_;
  std::vector<Plane> planes_;
  std::vector<float> costs_; ///< lengths of the shortest ways so far
  std::vector<bool> settled_;
  using Reached = std::pair<float, std::uint32_t>; ///< by how long a way, and which pixel
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
