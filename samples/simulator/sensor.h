// What a colour and depth camera makes of light and of true depth.
// Noise: Nguyen, Izadi, Lovell, "Modeling Kinect Sensor Noise", 2012; shadow and quantisation: structured light, as in
// Handa et al., "A Benchmark for RGB-D Visual Odometry, 3D Reconstruction and SLAM", 2014.
#pragma once

#include "core/image.h"
#include "core/random.h"
#include "renderer.h"

namespace kinora::simulator {

struct SensorFaults {
  double noise = 1;             ///< in units of core/sensor_noise.h
  double baseline = 0.075;      ///< metres to the projector, along x; what it does not light has no depth
  double disparity_step = 0;    ///< pixels: depth comes in steps of z²·step/(f·baseline); 0: in millimetres alone
  double lost_at_edges = 0.45;  ///< share of the pixels beside a jump that have no depth …
  double flying_at_edges = 0.2; ///< … or lie somewhere between
  double holes = 3;             ///< blobs without depth, in each frame
  double range = 3.2;           ///< metres: nothing is measured beyond
  double colour_noise = 1;      ///< of 255, at middle grey
  double exposure_drift = 0;    ///< share by which exposure goes up and down within two seconds
  double colour_delay = 0;      ///< seconds by which colour is older than depth, unknown to the time stamps
  int jpeg_quality = 92;
};

/// Depth in millimetres (0: none) of a frame that a renderer saw without faults. `seen` of the same surfaces.
DepthImage16 measure_depth(const std::vector<Surface>& surfaces, const Camera& camera, const DepthImage& truth,
                           const SensorFaults& faults, Random& random);

/// sRGB of linear light at a time.
ColorImage expose(const Image<float>& light, double seconds, const SensorFaults& faults, Random& random);
/// The same without faults.
ColorImage expose(const Image<float>& light);

} // namespace kinora::simulator
