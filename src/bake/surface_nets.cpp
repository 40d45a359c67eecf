#include "bake/surface_nets.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/parallel.h"

namespace kinora::bake {
namespace {

constexpr float kMaxExtrapolation =
    2; ///< of the values below: how steep density is matters little, where it passes the level much
constexpr float kUnoccupied = -std::numeric_limits<float>::infinity();
constexpr std::uint32_t kNone = 0xFFFFFFFFU;

/// Works through the grid slice by slice. Values are log(density / level), cut to ±kMaxExtrapolation, positive inside;
/// kUnoccupied where nothing is stored.
class NetBuilder {
public:
  NetBuilder(const FieldSampler& sampler, double level, int resolution)
      : sampler_(sampler), level_(static_cast<float>(level)), n_(resolution),
        step_(sampler.field().config.box.side / resolution), below_(points_per_slice(), kUnoccupied),
        above_(points_per_slice(), kUnoccupied), cells_before_(cells_per_layer(), kNone),
        cells_(cells_per_layer(), kNone) {}

  Triangles run(const Progress& progress) {
    for (int z = 0; z < n_; ++z) {
      progress.check();
      sample_slice(z + 1, above_);
      position_vertices(z);
      join_slice(z);
      join_layer();
      below_.swap(above_);
      cells_before_.swap(cells_);
    }
    return std::move(out_);
  }

private:
  std::size_t points_per_slice() const { return static_cast<std::size_t>(n_ + 1) * static_cast<std::size_t>(n_ + 1); }
  std::size_t cells_per_layer() const { return static_cast<std::size_t>(n_) * static_cast<std::size_t>(n_); }
  std::size_t point(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(n_ + 1) + static_cast<std::size_t>(x);
  }
  std::size_t cell(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(n_) + static_cast<std::size_t>(x);
  }
  Eigen::Vector3d position(double x, double y, double z) const {
    return sampler_.field().config.box.origin + step_ * Eigen::Vector3d(x, y, z);
  }

  // Points on the box's faces count as outside, so that the surface is closed.
  void sample_slice(int z, std::vector<float>& values) {
    std::fill(values.begin(), values.end(), kUnoccupied);
    if (z == n_) return;
    wanted_.clear();
    points_.clear();
    for (int y = 1; y < n_; ++y) {
      for (int x = 1; x < n_; ++x) {
        const Eigen::Vector3d p = position(x, y, z);
        if (!sampler_.occupied(p)) continue;
        wanted_.push_back(point(x, y));
        points_.push_back(p);
      }
    }
    parallel_for(points_.size(), 2048, [&](const Chunk& chunk) {
      FieldSamples samples;
      sampler_.evaluate(std::span(points_).subspan(chunk.begin, chunk.end - chunk.begin), samples);
      for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
        const float value = std::log(samples.density[i - chunk.begin] / level_);
        values[wanted_[i]] = std::clamp(value, -kMaxExtrapolation, kMaxExtrapolation);
      }
    });
  }

  // A vertex in each cell between the two slices whose corners are not all on one side.
  void position_vertices(int z) {
    std::fill(cells_.begin(), cells_.end(), kNone);
    for (int y = 0; y < n_; ++y) {
      for (int x = 0; x < n_; ++x) {
        std::array<float, 8> v{};
        int inside = 0;
        for (int k = 0; k < 8; ++k) {
          const auto& slice = k & 4 ? above_ : below_;
          v[static_cast<std::size_t>(k)] = slice[point(x + (k & 1), y + ((k >> 1) & 1))];
          inside += v[static_cast<std::size_t>(k)] > 0 ? 1 : 0;
        }
        if (inside == 0 || inside == 8) continue;
        cells_[cell(x, y)] = static_cast<std::uint32_t>(out_.positions.size());
        out_.positions.push_back(mean_crossing(v, {x, y, z}));
      }
    }
  }

  /// Of the edges of the cell whose lowest corner is the grid's point `low`.
  Eigen::Vector3d mean_crossing(const std::array<float, 8>& v, const std::array<int, 3>& low) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    int count = 0;
    for (int k = 0; k < 8; ++k) {
      for (int axis = 0; axis < 3; ++axis) {
        const int other = k | (1 << axis);
        if (other == k) continue;
        const float a = v[static_cast<std::size_t>(k)];
        const float b = v[static_cast<std::size_t>(other)];
        if ((a > 0) == (b > 0)) continue;
        const auto corner = [&](int i) {
          return position(low[0] + (i & 1), low[1] + ((i >> 1) & 1), low[2] + (i >> 2));
        };
        sum += a > 0 ? crossing(corner(k), a, corner(other), b) : crossing(corner(other), b, corner(k), a);
        ++count;
      }
    }
    return sum / count;
  }

  /// Between a point inside and one outside: where the values in between pass 0, or where what is stored ends.
  Eigen::Vector3d crossing(const Eigen::Vector3d& inside, float a, const Eigen::Vector3d& outside, float b) const {
    if (b != kUnoccupied) return inside + (outside - inside) * static_cast<double>(a / (a - b));
    constexpr int kSteps = 6;
    double stored = 0;
    double empty = 1;
    for (int step = 0; step < kSteps; ++step) {
      const double middle = (stored + empty) / 2;
      (sampler_.occupied(inside + (outside - inside) * middle) ? stored : empty) = middle;
    }
    return inside + (outside - inside) * ((stored + empty) / 2);
  }

  // Faces across the edges that lie in the lower slice: between this layer of cells and the one before.
  void join_slice(int z) {
    if (z == 0) return;
    for (int y = 1; y < n_; ++y) {
      for (int x = 1; x < n_; ++x) {
        const float here = below_[point(x, y)];
        add_quad(
            here, below_[point(x + 1, y)],
            {cells_before_[cell(x, y - 1)], cells_before_[cell(x, y)], cells_[cell(x, y)], cells_[cell(x, y - 1)]});
        add_quad(
            here, below_[point(x, y + 1)],
            {cells_before_[cell(x - 1, y)], cells_[cell(x - 1, y)], cells_[cell(x, y)], cells_before_[cell(x, y)]});
      }
    }
  }

  // Faces across the edges from the lower slice to the upper one.
  void join_layer() {
    for (int y = 1; y < n_; ++y) {
      for (int x = 1; x < n_; ++x) {
        add_quad(below_[point(x, y)], above_[point(x, y)],
                 {cells_[cell(x - 1, y - 1)], cells_[cell(x, y - 1)], cells_[cell(x, y)], cells_[cell(x - 1, y)]});
      }
    }
  }

  // `corners` go counterclockwise seen from where the edge ends; that is outside if it begins inside.
  void add_quad(float begin, float end, std::array<std::uint32_t, 4> corners) {
    if ((begin > 0) == (end > 0)) return;
    if (end > 0) std::swap(corners[1], corners[3]);
    const auto squared = [&](int a, int b) {
      return (out_.positions[corners[static_cast<std::size_t>(a)]] -
              out_.positions[corners[static_cast<std::size_t>(b)]])
          .squaredNorm();
    };
    if (squared(0, 2) > squared(1, 3)) std::rotate(corners.begin(), corners.begin() + 1, corners.end());
    out_.faces.push_back({corners[0], corners[1], corners[2]});
    out_.faces.push_back({corners[0], corners[2], corners[3]});
  }

  const FieldSampler& sampler_;
  float level_;
  int n_;
  double step_;
  std::vector<float> below_, above_;                // values at the points of two slices
  std::vector<std::uint32_t> cells_before_, cells_; // vertex of each cell of two layers
  std::vector<std::size_t> wanted_;
  std::vector<Eigen::Vector3d> points_;
  Triangles out_;
};

/// Union-find over vertices.
class DisjointSets {
public:
  explicit DisjointSets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0U); }
  std::uint32_t find(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::uint32_t a, std::uint32_t b) { parent_[find(a)] = find(b); }

private:
  std::vector<std::uint32_t> parent_;
};

} // namespace

Triangles surface_nets(const FieldSampler& sampler, double level, int resolution, const Progress& progress) {
  return NetBuilder(sampler, level, resolution).run(progress);
}

void keep_vertices(Triangles& triangles, const std::vector<std::uint8_t>& keep) {
  std::erase_if(triangles.faces, [&](const auto& face) {
    return std::any_of(face.begin(), face.end(), [&](std::uint32_t v) { return keep[v] == 0; });
  });
  std::vector<std::uint32_t> renumbered(triangles.positions.size(), kNone);
  for (const auto& face : triangles.faces) {
    for (const std::uint32_t v : face) renumbered[v] = 0;
  }
  std::uint32_t count = 0;
  for (std::size_t v = 0; v < renumbered.size(); ++v) {
    if (renumbered[v] == kNone) continue;
    renumbered[v] = count;
    triangles.positions[count++] = triangles.positions[v];
  }
  triangles.positions.resize(count);
  for (auto& face : triangles.faces) {
    for (std::uint32_t& v : face) v = renumbered[v];
  }
}

void remove_small_components(Triangles& triangles, double share) {
  const std::size_t count = triangles.positions.size();
  DisjointSets components(count);
  for (const auto& face : triangles.faces) {
    components.join(face[0], face[1]);
    components.join(face[0], face[2]);
  }
  std::vector<std::size_t> faces(count, 0);
  std::size_t largest_component = 0;
  for (const auto& face : triangles.faces)
    largest_component = std::max(largest_component, ++faces[components.find(face[0])]);
  std::vector<std::uint8_t> keep(count, 0);
  for (std::size_t v = 0; v < count; ++v) {
    const std::size_t component_faces = faces[components.find(static_cast<std::uint32_t>(v))];
    keep[v] =
        component_faces > 0 && static_cast<double>(component_faces) >= share * static_cast<double>(largest_component)
            ? 1
            : 0;
  }
  keep_vertices(triangles, keep);
}

std::vector<Eigen::Vector3d> vertex_normals(const Triangles& triangles) {
  std::vector<Eigen::Vector3d> normals(triangles.positions.size(), Eigen::Vector3d::Zero());
  for (const auto& face : triangles.faces) {
    const Eigen::Vector3d& a = triangles.positions[face[0]];
    const Eigen::Vector3d across = (triangles.positions[face[1]] - a).cross(triangles.positions[face[2]] - a);
    for (const std::uint32_t v : face) normals[v] += across;
  }
  for (Eigen::Vector3d& normal : normals) {
    const double length = normal.norm();
    normal = length > 0 ? Eigen::Vector3d(normal / length) : Eigen::Vector3d::UnitZ();
  }
  return normals;
}

} // namespace kinora::bake
