// What views warped to one place can tell about it, and what they cannot.
#pragma once

#include <span>

#include "ingest/frame/reduced_view.h"

namespace kinora::ingest {

/// `seen`: the samples as a camera elsewhere would have seen them (reproject), in the same order. A surface that a
/// sample shows behind another sample's, from that camera, tells that the nearer one is gone only if the sample looks
/// through the place where that was; else the sample looks past it, from the side. Such readings become kUnseen.
/// Nothing changes in views from the camera's own place. The same bits for any number of threads.
void drop_oblique_readings(std::span<const ReducedView> samples, std::span<ReducedView> seen);

} // namespace kinora::ingest
