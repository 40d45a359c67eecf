#include "ingest/frame/label_borders.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <map>
#include <queue>
#include <utility>
#include <vector>

namespace kinora::ingest {
namespace {

constexpr int kReach = 80;             ///< of the longer side
constexpr float kSlope = 0.01F;        ///< of the depth: from one pixel to the next, that is a surface
constexpr float kJump = 0.04F;         ///< … more than that, certainly the edge of one
constexpr int kColorJump = 80;         ///< of 255, in any channel: certainly an edge …
constexpr float kOfColor = 0.6F;       ///< … but no edge of depth
constexpr int kVoidReach = 2;          ///< pixels; a hole narrower than that is no edge
constexpr std::size_t kMinPixels = 50; ///< of a border; fewer tell nothing
constexpr double kMinShare = 0.1;      ///< of a border's pixels
constexpr double kMinEdges = 0.2;      ///< of a line of pixels, to be the edge of something …
constexpr double kClearly = 1.3;       ///< … and more than the border
constexpr double kMinContrast = 1.5;   ///< of borders that are right
constexpr double kMaxOffset = 0.2;     ///< … of border_reach()

struct Place {
  int u, v;
};
constexpr std::array<Place, 4> kBeside{{{-1, 0}, {1, 0}, {0, -1}, {0, 1}}};

/// Depth without narrow holes: those have the farthest of what lies beside them, wide ones 0.
DepthImage without_narrow_holes(const DepthImage& depth) {
  const int width = depth.width();
  const int height = depth.height();
  std::vector<int> measured(static_cast<std::size_t>(width + 1) * static_cast<std::size_t>(height + 1), 0);
  const auto sum = [&](int u, int v) -> int& {
    return measured[static_cast<std::size_t>(v) * static_cast<std::size_t>(width + 1) + static_cast<std::size_t>(u)];
  };
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u)
      sum(u + 1, v + 1) = sum(u, v + 1) + sum(u + 1, v) - sum(u, v) + (depth.at(u, v) > 0 ? 1 : 0);
  DepthImage filled = depth;
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const int left = std::max(u - kVoidReach, 0), right = std::min(u + kVoidReach + 1, width);
      const int top = std::max(v - kVoidReach, 0), bottom = std::min(v + kVoidReach + 1, height);
      const int count = sum(right, bottom) - sum(left, bottom) - sum(right, top) + sum(left, top);
      const bool is_solid = 2 * count > (right - left) * (bottom - top);
      if (is_solid == (depth.at(u, v) > 0)) continue;
      float farthest = 0;
      for (int y = top; is_solid && y < bottom; ++y)
        for (int x = left; x < right; ++x) farthest = std::max(farthest, depth.at(x, y));
      filled.at(u, v) = farthest;
    }
  }
  return filled;
}

/// 0 within a surface to 1.
float depth_edge(float a, float b) {
  if ((a > 0) != (b > 0)) return 1;
  const float nearer = std::min(a, b);
  return std::clamp((std::abs(a - b) - kSlope * nearer) / (kJump * nearer + 1e-9F), 0.0F, 1.0F);
}

float color_edge(const std::uint8_t* a, const std::uint8_t* b) {
  int largest = 0;
  for (int c = 0; c < 3; ++c) largest = std::max(largest, std::abs(a[c] - b[c]));
  return std::min(static_cast<float>(largest) / kColorJump, 1.0F);
}

/// Steps from each pixel to the nearest of those `from` which it is counted, at most `most`; `most` + 1 beyond.
Image<std::uint8_t> steps_from(std::vector<Place> from, int width, int height, int most) {
  Image<std::uint8_t> steps(width, height, 1, static_cast<std::uint8_t>(most + 1));
  for (const Place& p : from) steps.at(p.u, p.v) = 0;
  for (int step = 1; step <= most; ++step) {
    std::vector<Place> next;
    for (const Place& p : from) {
      for (const Place& beside : kBeside) {
        const Place q{p.u + beside.u, p.v + beside.v};
        if (!steps.contains(q.u, q.v) || steps.at(q.u, q.v) <= step) continue;
        steps.at(q.u, q.v) = static_cast<std::uint8_t>(step);
        next.push_back(q);
      }
    }
    from = std::move(next);
  }
  return steps;
}

/// Pixels beside one that `differs(p, q)` from them, on both sides.
template <class Differs> std::vector<Place> border_pixels(int width, int height, const Differs& differs) {
  std::vector<Place> found;
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const Place p{u, v};
      const bool is_border = std::any_of(kBeside.begin(), kBeside.end(), [&](const Place& beside) {
        const Place q{u + beside.u, v + beside.v};
        return q.u >= 0 && q.v >= 0 && q.u < width && q.v < height && differs(p, q);
      });
      if (is_border) found.push_back(p);
    }
  }
  return found;
}

std::vector<Place> border_pixels(const LabelImage& labels) {
  return border_pixels(labels.width(), labels.height(),
                       [&](const Place& p, const Place& q) { return labels.at(p.u, p.v) != labels.at(q.u, q.v); });
}

/// The border that each pixel is nearest to.
struct NearBorder {
  std::uint8_t low = 0, high = 0; ///< labels on both sides; equal: none within reach
  std::int16_t at = 0;            ///< steps from it: 1, 2… on the side of `high`, 0, −1… on that of `low`
};

Image<NearBorder> near_borders(const LabelImage& labels, int reach) {
  Image<NearBorder> near(labels.width(), labels.height());
  std::vector<Place> from = border_pixels(labels);
  for (const Place& p : from) {
    const std::uint8_t own = labels.at(p.u, p.v);
    for (const Place& beside : kBeside) {
      const Place q{p.u + beside.u, p.v + beside.v};
      if (!labels.contains(q.u, q.v) || labels.at(q.u, q.v) == own) continue;
      const std::uint8_t other = labels.at(q.u, q.v);
      near.at(p.u, p.v) = {std::min(own, other), std::max(own, other), static_cast<std::int16_t>(own > other ? 1 : 0)};
    }
  }
  for (int step = 1; step < reach; ++step) {
    std::vector<Place> next;
    for (const Place& p : from) {
      for (const Place& beside : kBeside) {
        const Place q{p.u + beside.u, p.v + beside.v};
        if (!labels.contains(q.u, q.v) || near.at(q.u, q.v).low != near.at(q.u, q.v).high) continue;
        near.at(q.u, q.v) = near.at(p.u, p.v);
        near.at(q.u, q.v).at = static_cast<std::int16_t>(near.at(p.u, p.v).at + (near.at(p.u, p.v).at > 0 ? 1 : -1));
        next.push_back(q);
      }
    }
    from = std::move(next);
  }
  return near;
}

/// Edges of depth along the lines that run beside a border, by their steps from it.
struct EdgesBeside {
  struct Line {
    double edges = 0;
    double pixels = 0;
    double share() const { return pixels > kMinPixels ? edges / pixels : 0; }
  };
  std::map<int, Line> lines;

  /// Where most of the edges are; 0 unless they are clearly more than at the border.
  int most() const {
    const auto best = std::max_element(
        lines.begin(), lines.end(), [](const auto& a, const auto& b) { return a.second.share() < b.second.share(); });
    const auto border = lines.find(0);
    const double at_border = border == lines.end() ? 0 : border->second.share();
    return best->second.share() > std::max(kMinEdges, kClearly * at_border) ? best->first : 0;
  }
};

/// Whole borders moved to where most edges of depth are beside them: masks are too wide or too narrow all around.
void shift_borders(const DepthImage& depth, int reach, LabelImage& labels) {
  const Image<NearBorder> near = near_borders(labels, reach);
  std::map<std::pair<int, int>, EdgesBeside> found;
  const auto look = [&](const Place& p, const Place& q) {
    if (!near.contains(q.u, q.v)) return;
    const NearBorder& a = near.at(p.u, p.v);
    const NearBorder& b = near.at(q.u, q.v);
    if (a.low == a.high || a.low != b.low || a.high != b.high || std::abs(a.at - b.at) != 1) return;
    EdgesBeside::Line& line = found[{a.low, a.high}].lines[std::min(a.at, b.at)];
    line.edges += depth_edge(depth.at(p.u, p.v), depth.at(q.u, q.v));
    line.pixels += 1;
  };
  for (int v = 0; v < labels.height(); ++v) {
    for (int u = 0; u < labels.width(); ++u) {
      look({u, v}, {u + 1, v});
      look({u, v}, {u, v + 1});
    }
  }
  std::map<std::pair<int, int>, int> shifts;
  for (const auto& [border, beside] : found) shifts[border] = beside.most();
  for (std::size_t i = 0; i < labels.pixel_count(); ++i) {
    const NearBorder& at = near.data()[i];
    if (at.low == at.high) continue;
    const auto shift = shifts.find({at.low, at.high});
    if (shift != shifts.end() && shift->second != 0) labels.data()[i] = at.at > shift->second ? at.high : at.low;
  }
}

/// Where a label is certain: beyond reach of any border, and along the middle of what is narrower; of the background
/// only where that lies behind what is labelled there, or nowhere.
bool is_certain(const Image<std::uint8_t>& steps, const LabelImage& labels, const DepthImage& depth, int u, int v,
                int reach) {
  const int own = steps.at(u, v);
  if (own > reach) return true;
  if (2 * own < reach) return false;
  for (int y = std::max(v - 1, 0); y <= std::min(v + 1, steps.height() - 1); ++y)
    for (int x = std::max(u - 1, 0); x <= std::min(u + 1, steps.width() - 1); ++x)
      if (steps.at(x, y) > own) return false;
  if (labels.at(u, v) != 0 || !(depth.at(u, v) > 0)) return true;
  for (int y = std::max(v - reach - 1, 0); y <= std::min(v + reach + 1, steps.height() - 1); ++y)
    for (int x = std::max(u - reach - 1, 0); x <= std::min(u + reach + 1, steps.width() - 1); ++x)
      if (labels.at(x, y) != 0 && depth_edge(depth.at(x, y), depth.at(u, v)) < 1) return false;
  return true;
}

struct Flood {
  float level;
  std::uint32_t order;
  Place at;
  std::uint8_t label;
  bool operator<(const Flood& other) const { // the lowest first, then who came first
    return level > other.level || (level == other.level && order > other.order);
  }
};

/// Labels grow from where they are certain over the lowest edges, and meet at the highest within reach of a border; far
/// ones count less.
template <class Edge> void flood(const DepthImage& depth, int reach, LabelImage& labels, const Edge& edge) {
  const Image<std::uint8_t> steps = steps_from(border_pixels(labels), labels.width(), labels.height(), reach);
  const auto weight = [&](const Place& p) {
    return 1 - static_cast<float>(std::min<int>(steps.at(p.u, p.v), reach)) / static_cast<float>(reach + 1);
  };
  std::priority_queue<Flood> queue;
  std::uint32_t order = 0;
  Image<std::uint8_t> done(labels.width(), labels.height());
  const auto spread = [&](const Flood& from) {
    for (const Place& beside : kBeside) {
      const Place q{from.at.u + beside.u, from.at.v + beside.v};
      if (!done.contains(q.u, q.v) || done.at(q.u, q.v) != 0) continue;
      queue.push({std::max(from.level, weight(q) * edge(from.at, q)), order++, q, from.label});
    }
  };
  for (int v = 0; v < labels.height(); ++v)
    for (int u = 0; u < labels.width(); ++u) done.at(u, v) = is_certain(steps, labels, depth, u, v, reach) ? 1 : 0;
  for (int v = 0; v < labels.height(); ++v)
    for (int u = 0; u < labels.width(); ++u)
      if (done.at(u, v) != 0 && steps.at(u, v) <= reach + 1) spread({0, 0, {u, v}, labels.at(u, v)});
  while (!queue.empty()) {
    const Flood next = queue.top();
    queue.pop();
    if (done.at(next.at.u, next.at.v) != 0) continue;
    done.at(next.at.u, next.at.v) = 1;
    labels.at(next.at.u, next.at.v) = next.label;
    spread(next);
  }
}

/// What is labelled background beside something may still be its rim: it must not stay in the air as a wall.
void forget_rims(int width, Frame& frame) {
  const LabelImage& labels = frame.labels;
  const Image<std::uint8_t> steps = steps_from(border_pixels(labels), labels.width(), labels.height(), width);
  for (std::size_t i = 0; i < labels.pixel_count(); ++i) {
    if (labels.data()[i] != 0 || steps.data()[i] > width) continue;
    frame.depth.data()[i] = 0;
    if (!frame.clean_depth.empty()) frame.clean_depth.data()[i] = 0;
  }
}

} // namespace

int border_reach(int width, int height) { return std::max(std::max(width, height) / kReach, 2); }

std::optional<double> border_contrast(const LabelImage& labels, const ColorImage& color) {
  const int reach = border_reach(labels.width(), labels.height());
  double across = 0, beside = 0;
  std::size_t pairs = 0, pairs_beside = 0;
  // Along rows, or columns: from one pixel to the next, and the same some steps before and after.
  const auto look = [&](int u, int v, int du, int dv) {
    if (!labels.contains(u + du, v + dv) || labels.at(u, v) == labels.at(u + du, v + dv)) return;
    const auto edge = [&](int step) {
      return color_edge(color.pixel(u + step * du, v + step * dv),
                        color.pixel(u + (step + 1) * du, v + (step + 1) * dv));
    };
    across += edge(0);
    ++pairs;
    for (int step = 2; step <= reach; ++step) {
      for (const int at : {-step, step}) {
        if (!color.contains(u + at * du, v + at * dv) || !color.contains(u + (at + 1) * du, v + (at + 1) * dv))
          continue;
        beside += edge(at);
        ++pairs_beside;
      }
    }
  };
  for (int v = 0; v < labels.height(); ++v) {
    for (int u = 0; u < labels.width(); ++u) {
      look(u, v, 1, 0);
      look(u, v, 0, 1);
    }
  }
  if (pairs == 0 || pairs_beside == 0) return std::nullopt;
  return across / static_cast<double>(pairs) / std::max(beside / static_cast<double>(pairs_beside), 1e-9);
}

std::optional<double> border_offset(const LabelImage& labels, const DepthImage& depth) {
  const int reach = border_reach(labels.width(), labels.height());
  const DepthImage filled = without_narrow_holes(depth);
  const std::vector<Place> borders = border_pixels(labels);
  const Image<std::uint8_t> steps =
      steps_from(border_pixels(depth.width(), depth.height(),
                               [&](const Place& p, const Place& q) {
                                 return depth_edge(filled.at(p.u, p.v), filled.at(q.u, q.v)) > 0.5F;
                               }),
                 depth.width(), depth.height(), reach);
  std::vector<std::uint8_t> found;
  for (const Place& p : borders)
    if (steps.at(p.u, p.v) <= reach) found.push_back(steps.at(p.u, p.v));
  if (found.size() < kMinPixels || static_cast<double>(found.size()) < kMinShare * static_cast<double>(borders.size()))
    return std::nullopt;
  const auto middle = found.begin() + static_cast<std::ptrdiff_t>(found.size() / 2);
  std::nth_element(found.begin(), middle, found.end());
  return *middle;
}

void lay_borders_on_edges(Frame& frame) {
  const int reach = border_reach(frame.labels.width(), frame.labels.height());
  const DepthImage depth = without_narrow_holes(frame.depth);
  const auto color = [&](const Place& p, const Place& q) {
    return color_edge(frame.color.pixel(p.u, p.v), frame.color.pixel(q.u, q.v));
  };
  shift_borders(depth, reach, frame.labels);
  flood(depth, reach, frame.labels, [&](const Place& p, const Place& q) {
    return std::max(depth_edge(depth.at(p.u, p.v), depth.at(q.u, q.v)), kOfColor * color(p, q));
  });
  flood(depth, std::max(reach / 4, 1), frame.labels, color); // sensors measure no rims
  forget_rims(reach / 2, frame);
}

bool repair_borders(Frame& frame) {
  if (!frame.has_labels()) return false;
  const std::optional<double> contrast = border_contrast(frame.labels, frame.color);
  if (!contrast || *contrast > kMinContrast) return false;
  const std::optional<double> offset = border_offset(frame.labels, frame.depth);
  if (!offset || *offset <= kMaxOffset * border_reach(frame.labels.width(), frame.labels.height())) return false;
  lay_borders_on_edges(frame);
  return true;
}

} // namespace kinora::ingest
