// How different two frames are by Instant-NVR's rule for key frames, the baseline of ours.
// Source: Jiang et al., "Instant-NVR", CVPR 2023, equations 5 to 7 and sec. 5.4 (their "similarity", which grows with
// what is different).
#pragma once

#include <vector>

#include "ingest/frame/frame.h"
#include "motion/motion.h"

namespace kinora::encode {

/// A layer in a frame as the equations see it.
struct PaperView {
  std::vector<bool> visible;                             ///< eq. 5, of each node; none of a layer that does not bend
  std::vector<Eigen::Quaterniond> rotations;             ///< of each node, in place of the joints of a body model
  Eigen::Vector3d translation = Eigen::Vector3d::Zero(); ///< metres, in the camera; of a layer that does not bend
};

PaperView paper_view(const ingest::Frame& frame, const motion::Motion& motion, int timeline_index);

/// E_h of a layer that bends, E_o of any other. Of graphs that grew between the two, the nodes count that both have.
double paper_distance(const PaperView& a, const PaperView& b, int frames_apart);

/// γ: frames are key frames that are farther from all others.
inline constexpr double kPaperGamma = 2.5;

} // namespace kinora::encode
