// Which part of a body each measured point lies on: BodyInCamera::match for many points side by side, in single
// precision. Vectorised with Highway and chosen at run time for the processor; tests/tracking/body/body_match_test.cpp
// keeps it equal to the other.
#pragma once

#include <array>
#include <span>

#include "tracking/body/body_evidence.h"

namespace kinora::tracking {

/// What explains a point.
struct PartMatch {
  int part;   ///< −1: nothing is near enough
  float cost; ///< squared metres, as BodyInCamera::Match has it
};

/// For each point the part that explains it at the least cost, and at less than `max_cost`; of those that `takes_part`
/// says. Serial.
void match_points(const BodyInCamera& body, std::span<const MeasuredPoint> points, double normal_length,
                  double max_cost, const std::array<bool, kBodyParts>& takes_part, std::span<PartMatch> matches);

/// Of all parts.
void match_points(const BodyInCamera& body, std::span<const MeasuredPoint> points, double normal_length,
                  double max_cost, std::span<PartMatch> matches);

} // namespace kinora::tracking
