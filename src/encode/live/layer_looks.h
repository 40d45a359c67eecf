// What a frame shows of a layer, and from which side: how much of it key frames know, and which of them saw what a
// camera is about to show.
#pragma once

#include <cstdint>
#include <vector>

#include "ingest/frame/frame.h"
#include "motion/motion.h"

namespace kinora::encode {

/// A place of a layer: the node nearest to it, or a cell of canonical space; and the direction from there to the
/// camera, in canonical space, of unit length.
struct Look {
  std::uint64_t place;
  Eigen::Vector3f towards_camera;
};

/// How a layer that does not bend is divided.
struct PlaceGrid {
  double side = 0; ///< of a cell, metres

  /// A sixteenth of what the frame shows of the layer. Nothing is measured: 0.
  static PlaceGrid of(const ingest::Frame& frame, int label);
};

/// By place, one look for each. `timeline_index`: of the frame, in the motion. Empty where the layer is lost or nothing
/// of it is measured. Thread-safe.
std::vector<Look> looks_of(const ingest::Frame& frame, int label, const motion::Motion& motion, int timeline_index,
                           const PlaceGrid& grid);

/// The directions from which a camera would see these places at a frame of the timeline, hidden or not. Places are
/// given by looks of any frame; of one that the motion does not know, nothing is seen: the direction is zero.
std::vector<Look> looks_from(const Eigen::Vector3d& camera_in_world, const std::vector<Look>& places,
                             const motion::Motion& motion, int timeline_index, const PlaceGrid& grid);

/// How much `seen` tells of `wanted`, from 0 to 1: over all wanted places, the mean of the squared cosine between the
/// two directions; nothing from the other side, and from places that were not seen. Both by place.
double similarity(const std::vector<Look>& seen, const std::vector<Look>& wanted);

} // namespace kinora::encode
