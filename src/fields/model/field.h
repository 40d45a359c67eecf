// A canonical radiance field: multiresolution hash grid, two small MLPs and stored occupancy.
// Source: Müller et al., "Instant Neural Graphics Primitives", ACM TOG 41(4), 2022; colour is deferred (composited
// features go once through the colour MLP), as in Hedman et al., "Baking Neural Radiance Fields", ICCV 2021.
#pragma once

#include <bit>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/large_buffer.h"

namespace kinora::fields {

/// Cube of canonical space that a field fills. Coordinates inside are relative: (point − origin) / side in [0, 1]³.
struct FieldBox {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero(); ///< smallest corner, metres
  double side = 1;                                  ///< metres

  bool operator==(const FieldBox& other) const { return origin == other.origin && side == other.side; }
};

/// Limits that every field keeps: what a file may ask for, and what training may choose.
struct FieldLimits {
  static constexpr int kMaxLevels = 8;
  static constexpr int kMaxLog2TableSize = 20;
  static constexpr int kMaxResolution = 8192;
  static constexpr int kMaxOccupancyResolution = 512;
  static constexpr float kMaxSharpness = 11.0F; ///< of either sign
};

/// What the density MLP's first output means (volume_density.h).
enum class Geometry : std::uint8_t {
  kDensity,       ///< the logarithm of density
  kSignedDistance ///< the distance from the surface in units of density_length(), positive outside
};

/// "density" or "signed_distance".
const char* name_of(Geometry geometry);

// Widths of the nets, multiples of 16: other ones are compiled in to measure them (bench/fields/curves). Clips say
// which they were made with, and are read with these alone.
#ifndef KINORA_HIDDEN
#define KINORA_HIDDEN 16
#endif
#ifndef KINORA_COLOR_HIDDEN
#define KINORA_COLOR_HIDDEN 32
#endif
#ifndef KINORA_VECTORS
#define KINORA_VECTORS 1
#endif

struct FieldConfig {
  static constexpr int kFeatures = 8;           ///< per level
  static constexpr int kHidden = KINORA_HIDDEN; ///< width of the density MLP's hidden layer
  static constexpr int kGeometry = 16;          ///< outputs of the density MLP: raw density, then 15 features
  static constexpr int kVectors =
      KINORA_VECTORS; ///< the first 3 · this features are vectors, which turn with the layer
  static constexpr int kColorHidden = KINORA_COLOR_HIDDEN; ///< width of the colour MLP's two hidden layers
  static constexpr int kColorOutputs = 16;                 ///< outputs of the colour MLP: red, green, blue, and padding

  FieldBox box;
  int levels = 4;           ///< even
  int log2_table_size = 15; ///< at most 2^this entries per level; levels that fit are stored densely
  int coarsest_resolution = 16;
  int finest_resolution = 256;    ///< cells per side of the finest level; levels in between grow geometrically
  int occupancy_resolution = 128; ///< cells per side of the stored occupancy; a multiple of 64
  Geometry geometry = Geometry::kDensity;

  int encoding_width() const { return levels * kFeatures; }
  /// Metres: side of a cell of the finest level.
  double cell_size() const { return box.side / finest_resolution; }
  /// Metres: densities are per this length, so that a raw density of zero means the same in a cup and in a room.
  double density_length() const { return 4 * cell_size(); }
  /// Throws Error(kCorruptInput), naming `source`, if any number is outside FieldLimits or not finite.
  void validate(const std::string& source) const;

  bool operator==(const FieldConfig&) const = default;
};

/// One bit for each cell of the box, x fastest. Outside is empty.
class Occupancy {
public:
  Occupancy() = default;
  explicit Occupancy(int resolution)
      : resolution_(resolution), bits_((static_cast<std::size_t>(resolution) * resolution * resolution + 63) / 64, 0) {}

  int resolution() const { return resolution_; }
  bool at(int x, int y, int z) const {
    const std::size_t i = index(x, y, z);
    return (bits_[i >> 6] >> (i & 63)) & 1;
  }
  void set(int x, int y, int z, bool occupied = true) {
    const std::size_t i = index(x, y, z);
    if (occupied) {
      bits_[i >> 6] |= std::uint64_t{1} << (i & 63);
    } else {
      bits_[i >> 6] &= ~(std::uint64_t{1} << (i & 63));
    }
  }
  std::size_t count() const;
  const std::vector<std::uint64_t>& words() const { return bits_; }
  std::vector<std::uint64_t>& words() { return bits_; }

private:
  std::size_t index(int x, int y, int z) const {
    const std::size_t r = static_cast<std::size_t>(resolution_);
    return (static_cast<std::size_t>(z) * r + static_cast<std::size_t>(y)) * r + static_cast<std::size_t>(x);
  }

  int resolution_ = 0;
  std::vector<std::uint64_t> bits_;
};

/// Calls `visit` with x, y and z of each occupied cell, x fastest.
template <class Visit> void for_each_occupied(const Occupancy& occupancy, const Visit& visit) {
  const int r = occupancy.resolution();
  for (std::size_t w = 0; w < occupancy.words().size(); ++w) {
    const std::uint64_t word = occupancy.words()[w];
    if (word == 0) continue;
    const std::size_t row = w * 64 / static_cast<std::size_t>(r);
    const int begin = static_cast<int>(w * 64 - row * static_cast<std::size_t>(r));
    int y = static_cast<int>(row) % r;
    int z = static_cast<int>(row) / r;
    int row_begin = 0; // in small grids a word has cells of several rows
    for (std::uint64_t bits = word; bits != 0; bits &= bits - 1) {
      int x = begin + std::countr_zero(bits) - row_begin;
      for (; x >= r; x -= r, row_begin += r) {
        if (++y < r) continue;
        y = 0;
        ++z;
      }
      visit(x, y, z);
    }
  }
}

/// Cells of `factor`³ cells, occupied where any of them is. The resolution must be a multiple of the factor.
Occupancy coarsened(const Occupancy& occupancy, int factor);

/// Placement of one level of the hash grid inside Field::table.
struct GridLevel {
  int resolution;       ///< cells per side; vertices are 0…resolution
  std::uint32_t offset; ///< first entry of the level, in entries of kFeatures floats
  std::uint32_t size;   ///< entries; a power of two if hashed
  bool hashed;          ///< false: entry (z·n + y)·n + x with n = resolution + 1
};

std::vector<GridLevel> grid_levels(const FieldConfig& config);
/// Entries of all levels together.
std::size_t grid_entry_count(const FieldConfig& config);

/// Parameters of one field. Plain data; thread-safe to read.
/// MLPs have no biases; a weight matrix is stored with the inputs as rows: w[input · outputs + output].
struct Field {
  FieldConfig config;
  LargeBuffer<float> table;       ///< grid_entry_count × kFeatures
  std::vector<float> density_net; ///< encoding_width × kHidden, then kHidden × kGeometry
  std::vector<float> color_net; ///< kGeometry × kColorHidden, kColorHidden × kColorHidden, kColorHidden × kColorOutputs
  float sharpness = 0;          ///< of a signed distance: logarithm of how fast density rises, per density_length()
  Occupancy occupancy;

  /// Zero parameters of the right sizes, empty occupancy.
  explicit Field(const FieldConfig& config);
  Field() = default;
  std::size_t parameter_count() const { return table.size() + density_net.size() + color_net.size(); }
};

/// Those of its levels that hold anything, and those before them: of a field that has come in part, the coarse ones.
std::vector<GridLevel> stored_levels(const Field& field);

} // namespace kinora::fields
