#include "core/row_lookup.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace kinora {
namespace {

constexpr int kLooks = 4;      // for the place that a row's pixel shows
constexpr int kBlock = 16;     // pixels
constexpr double kFar = 1e4;   // metres: where nothing is known
constexpr double kSame = 0.02; // share of its depth by which a place may differ from where it was looked for

} // namespace

RowLookup::RowLookup(const DepthImage& depth, const Intrinsics& intrinsics, const Twist& readout)
    : depth_(depth), intrinsics_(intrinsics),
      nearest_(depth.width() / kBlock + 1, depth.height() / kBlock + 1, 1, kFar) {
  for (int v = 0; v < intrinsics.height; ++v) to_row_.push_back(exp_se3(-row_time(v, intrinsics.height) * readout));
  for (int v = 0; v < depth.height(); ++v) {
    for (int u = 0; u < depth.width(); ++u) {
      const auto metres = static_cast<double>(depth.at(u, v));
      if (!(metres > 0)) continue;
      for (int row = v / kBlock - 1; row <= v / kBlock + 1; ++row) {
        for (int column = u / kBlock - 1; column <= u / kBlock + 1; ++column) {
          if (nearest_.contains(column, row)) nearest_.at(column, row) = std::min(nearest_.at(column, row), metres);
        }
      }
    }
  }
}

double RowLookup::depth_at(const Eigen::Vector2d& at) const {
  const auto metres =
      static_cast<double>(depth_.at(static_cast<int>(std::lround(at.x())), static_cast<int>(std::lround(at.y()))));
  return metres > 0 ? metres : kFar;
}

// Beginning with a surface at that depth in the row's camera.
RowLookup::Place RowLookup::look(int u, int v, double depth) const {
  const SE3& to_row = to_row_[static_cast<std::size_t>(v)];
  const SE3 from_row = to_row.inverse();
  const Eigen::Vector2d last(intrinsics_.width - 1, intrinsics_.height - 1);
  Place place{{u, v}, depth, false};
  for (int i = 0; i < kLooks && !place.is_found; ++i) {
    const Eigen::Vector3d seen = from_row * intrinsics_.unproject(u, v, place.depth);
    if (!(seen.z() > 0)) break;
    const Eigen::Vector2d at = intrinsics_.project(seen);
    place.at = at.cwiseMax(Eigen::Vector2d::Zero()).cwiseMin(last);
    const double there = depth_at(place.at);
    place.is_found = place.at == at && std::abs(there - seen.z()) < kSame * there;
    place.depth = (to_row * intrinsics_.unproject(place.at.x(), place.at.y(), there)).z();
  }
  return place;
}

RowLookup::Place RowLookup::place_of(int u, int v) const {
  const Place here = look(u, v, depth_at({u, v}));
  const Place before = look(u, v, nearest_.at(u / kBlock, v / kBlock));
  Place chosen = before.is_found && (!here.is_found || before.depth < here.depth) ? before : here;
  if (depth_at(chosen.at) == kFar || !(chosen.depth > 0)) chosen.depth = 0;
  return chosen;
}

} // namespace kinora
