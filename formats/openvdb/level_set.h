// The surface of a fog volume as a signed distance.
#pragma once

#include <openvdb/openvdb.h>

namespace kinora::formats {

/// Metres from each voxel's centre to where the fog becomes opaque (half of the light passes a voxel), negative inside,
/// within three voxels of it: a level set without a name. Exact to a tenth of a voxel beside the surface, to half a
/// voxel at the end of the band. `density`: extinction per metre. Hollows stay outside.
openvdb::FloatGrid::Ptr level_set_of(const openvdb::FloatGrid& density);

} // namespace kinora::formats
