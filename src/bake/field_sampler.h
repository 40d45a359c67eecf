// What a field holds at points of canonical space.
#pragma once

#include <array>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "fields/model/field.h"

namespace kinora::bake {

/// Density and features of points.
struct FieldSamples {
  static constexpr std::size_t kFeatures = fields::FieldConfig::kGeometry - 1;

  std::vector<float> density;                         ///< extinction per metre; 0 where the field is empty
  std::vector<std::array<float, kFeatures>> features; ///< of colour; meaningless where the density is 0 or it is solid
};

/// Keeps a reference to the field. What its occupancy encloses is solid, as dense as anything can be. Thread-safe.
class FieldSampler {
public:
  explicit FieldSampler(const fields::Field& field);

  const fields::Field& field() const { return *field_; }
  /// Is the point in an occupied or an enclosed cell?
  bool occupied(const Eigen::Vector3d& canonical) const;
  /// Points in metres. On the calling thread: callers divide the work.
  void evaluate(std::span<const Eigen::Vector3d> canonical, FieldSamples& samples) const;
  /// Colours of mean features (weighted by what each sample contributes; vectors as they are turned), sRGB in [0, 1].
  std::vector<std::array<float, 3>> colors(std::span<const std::array<float, FieldSamples::kFeatures>> features) const;

private:
  const fields::Field* field_;
  fields::Occupancy enclosed_;
  std::vector<fields::GridLevel> levels_;
};

} // namespace kinora::bake
