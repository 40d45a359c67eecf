// The noise of structured-light and time-of-flight depth along the optical axis.
// Source: Nguyen, Izadi, Lovell, "Modeling Kinect Sensor Noise for Improved 3D Reconstruction and Tracking", 2012.
#pragma once

namespace kinora::ingest {

/// Standard deviation in metres of a measurement at depth z (metres): 1.2 mm + 1.9 mm·(z − 0.4)².
constexpr double depth_sigma(double z) { return 0.0012 + 0.0019 * (z - 0.4) * (z - 0.4); }

} // namespace kinora::ingest
