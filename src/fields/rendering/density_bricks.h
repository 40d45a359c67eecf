// A field's density, looked up instead of computed: sampled once on a regular lattice and kept in sparse bricks where
// the field is not empty.
// Source: Hedman et al., "Baking Neural Radiance Fields", ICCV 2021 (sparse bricks); the logarithm of density is what
// is interpolated, which keeps surfaces where they are.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/large_buffer.h"
#include "fields/model/field.h"

namespace kinora::fields {

enum class BrickDetail {
  kWhole,
  kHalf ///< samples twice as far apart along each axis: an eighth of the work, for a first look
};

/// Lattice coordinates: relative position (FieldBox) times resolution(), which is the field's finest, doubled or
/// halved. A brick holds the samples 8b … 8b + 8 along each axis, so that interpolation between them needs no other
/// brick. Immutable, thread-safe.
class DensityBricks {
public:
  static constexpr int kSide = 8; ///< lattice steps per side of a brick
  static constexpr int kLevels = kSide + 1;
  /// Pairs per brick: x, then y, then z fastest to slowest; y from 0 to 7, x and z from 0 to 8.
  static constexpr int kPairs = kLevels * kSide * kLevels;
  static constexpr int kMaxResolution = 1024;
  /// A byte b stands for the raw density kLowest + b · kStep; 0 for what is empty.
  static constexpr float kLowest = -8.0F;
  static constexpr float kStep = 19.0F / 255.0F; ///< the largest is kMaxRawDensity

  /// Where all raw densities are below this, more than 98 % of the light passes.
  static constexpr std::uint8_t kVisible = 54;

  DensityBricks() = default;
  /// Uses all threads; same bits for any number of them.
  explicit DensityBricks(const Field& field, BrickDetail detail = BrickDetail::kWhole);

  /// The field's finest, doubled or halved; half of that with BrickDetail::kHalf.
  int resolution() const { return resolution_; }
  int bricks_per_side() const { return (resolution_ + kSide - 1) / kSide; }
  std::size_t count() const { return coordinates_.size(); }
  /// Coordinates of brick `brick`, in bricks.
  const std::array<int, 3>& coordinates(std::size_t brick) const { return coordinates_[brick]; }
  /// Number of the brick there, or −1; anywhere outside too.
  int brick_at(int x, int y, int z) const;

  /// bricks_per_side³, x fastest: number of the brick or −1.
  const std::int32_t* index() const { return index_.data(); }
  /// Per brick kPairs: bytes, lowest first, of the samples (x, y) and (x, y + 1). Two of them, side by side, are the
  /// corners of a square.
  const std::uint16_t* pairs() const { return pairs_.data(); }

  /// The largest byte among the samples of a cube within a brick, `low` … `low` + `side` lattice steps along each axis.
  std::uint8_t largest(std::size_t brick, const std::array<int, 3>& low, int side) const;

  /// Raw density at lattice coordinates; kLowest where there is no brick.
  float raw_density(const std::array<float, 3>& at) const;

private:
  int resolution_ = 0;
  std::vector<std::int32_t> index_;
  std::vector<std::array<int, 3>> coordinates_;
  LargeBuffer<std::uint16_t> pairs_;
};

} // namespace kinora::fields
