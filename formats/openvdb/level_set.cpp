#include "openvdb/level_set.h"

#include <cmath>

#include <openvdb/tools/MeshToVolume.h>
#include <openvdb/tools/SignedFloodFill.h>
#include <openvdb/tools/VolumeToMesh.h>

namespace kinora::formats {
namespace {

constexpr double kOpaque = 0.5;
constexpr float kBand = 3; ///< voxels to either side, as OpenVDB's tools expect

/// The share of light that each voxel stops: it crosses one half nearer to the surface than density, which has no top.
openvdb::FloatGrid::Ptr opacity_of(const openvdb::FloatGrid& density) {
  auto opacity = density.deepCopy();
  const double voxel = density.voxelSize().x();
  for (auto value = opacity->beginValueOn(); value; ++value)
    value.setValue(static_cast<float>(1 - std::exp(-*value * voxel)));
  return opacity;
}

} // namespace

openvdb::FloatGrid::Ptr level_set_of(const openvdb::FloatGrid& density) {
  const auto opacity = opacity_of(density);
  std::vector<openvdb::Vec3s> points;
  std::vector<openvdb::Vec4I> quads;
  openvdb::tools::volumeToMesh(*opacity, points, quads, kOpaque);
  auto distance =
      openvdb::tools::meshToUnsignedDistanceField<openvdb::FloatGrid>(density.transform(), points, {}, quads, kBand);
  const auto opacities = opacity->getConstAccessor();
  for (auto value = distance->beginValueOn(); value; ++value) {
    if (opacities.getValue(value.getCoord()) > kOpaque) value.setValue(-*value);
  }
  openvdb::tools::signedFloodFill(distance->tree());
  distance->setGridClass(openvdb::GRID_LEVEL_SET);
  return distance;
}

} // namespace kinora::formats
