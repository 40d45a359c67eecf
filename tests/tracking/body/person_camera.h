// A colour and depth camera that sees dressed people, with the faults of a sensor, and what is true of what it sees.
#pragma once

#include <cstdint>

#include "evaluate/ground_truth_tracks.h"
#include "ingest/frame/frame.h"
#include "tracking/body/person_scenes.h"

namespace kinora::tracking::testing {

struct PersonCamera {
  int width = 640;
  int height = 480;
  double focal = 525;
  std::uint64_t seed = 1;
};

/// The scene's frame (from 0), label 1, before a wall at 4 m that is out of the sensor's range. Depth has the noise of
/// sensor_noise.h in whole millimetres, loses half of what lies beside a jump and makes flying pixels of a fifth of it.
/// Colour has noise, and motion blur if the scene has exposure.
ingest::Frame see_person(const PersonScene& scene, int frame, const PersonCamera& camera = {});

/// About `count` material points, evenly over the person, and for each in every frame where it is and whether the
/// camera sees it. `parts`: of these alone (empty: of all). Ids are the same for any `parts`.
evaluate::GroundTruthTracks track_person(const PersonScene& scene, std::size_t count, const PersonCamera& camera = {},
                                         std::span<const std::size_t> parts = {});

} // namespace kinora::tracking::testing
