// Which part of a body each measured point lies on: BodyInCamera::match for many points side by side, in single
// precision. Vectorised with Highway and chosen at run time for the processor; tests/tracking/body/body_match_test.cpp
// keeps it equal to the other.
#pragma once

#include <span>

#include "tracking/body/body_evidence.h"

namespace kinora::tracking {

/// For each point the part that explains it at the least cost, and at less than `most`; −1: none. Serial.
void match_points(const BodyInCamera& body, std::span<const MeasuredPoint> points, double normal_length, double most,
                  std::span<int> parts);

} // namespace kinora::tracking
