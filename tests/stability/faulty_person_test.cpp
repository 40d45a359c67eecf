// A person seen by a sensor that fails, frames that are lost, and things that stand before him.
#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include <gtest/gtest.h>

#include "core/random.h"
#include "ingest/sensor_noise.h"
#include "tracking/body/person_camera.h"
#include "tracking/deforming_tracker.h"
#include "tracking/point_track.h"

namespace kinora::tracking {
namespace {

constexpr int kFrames = 40;
constexpr std::size_t kPoints = 200;
constexpr testing::PersonCamera kCamera{320, 240, 262.5};

/// What becomes of a frame; false: it never arrives.
using Fault = std::function<bool(ingest::Frame&, Random&)>;

struct Case {
  const char* name;
  Fault fault;
  double bound; ///< metres, of the mean error of seen points
};

struct Followed {
  double mean_error = 0; ///< metres, of points while they are seen, each from where it was seen first
  int not_tracked = 0;
  int arrived = 0;
};

Followed follow(const Fault& fault) {
  testing::PersonScene scene = testing::person_scene("clap");
  scene.frames = kFrames;
  DeformingTracker tracker(1);
  Followed result;
  std::vector<int> number(kFrames, -1); // of each frame that arrives
  for (int i = 0; i < kFrames; ++i) {
    ingest::Frame frame = testing::see_person(scene, i, kCamera);
    Random random(7, static_cast<std::uint64_t>(i));
    if (!fault(frame, random)) continue;
    number[static_cast<std::size_t>(i)] = result.arrived++;
    if (tracker.track(frame).health != Health::kTracked) ++result.not_tracked;
  }
  const Motion motion = tracker.motion();
  double count = 0;
  for (const auto& [id, places] : testing::track_person(scene, kPoints, kCamera)) {
    const auto seen = [&](const auto& place) {
      return place.second.visible && number[static_cast<std::size_t>(place.first)] >= 0;
    };
    const auto first = std::find_if(places.begin(), places.end(), seen);
    if (first == places.end()) continue;
    const auto at = [&](int frame) { return static_cast<std::size_t>(number[static_cast<std::size_t>(frame)]); };
    const auto track =
        track_point(motion, static_cast<std::size_t>(result.arrived), at(first->first), first->second.point);
    for (const auto& place : places) {
      if (!seen(place)) continue;
      const double error = (track[at(place.first)] - place.second.point).norm();
      EXPECT_TRUE(std::isfinite(error));
      result.mean_error += error;
      ++count;
    }
  }
  result.mean_error /= count;
  return result;
}

bool nothing(ingest::Frame&, Random&) { return true; }

bool triple_noise(ingest::Frame& frame, Random& random) {
  for (float& z : frame.depth.values()) {
    if (z > 0) z += static_cast<float>(std::sqrt(8.0) * ingest::depth_sigma(z) * random.normal());
  }
  return true;
}

/// A quarter of the picture, in squares of five pixels.
bool holes(ingest::Frame& frame, Random& random) {
  constexpr int kSide = 5;
  for (int v = 0; v < frame.depth.height(); v += kSide) {
    for (int u = 0; u < frame.depth.width(); u += kSide) {
      if (random.below(4) > 0) continue;
      for (int y = v; y < std::min(v + kSide, frame.depth.height()); ++y) {
        for (int x = u; x < std::min(u + kSide, frame.depth.width()); ++x) frame.depth.at(x, y) = 0;
      }
    }
  }
  return true;
}

/// Three pixels on either side of every jump lie anywhere between.
bool flying_pixels(ingest::Frame& frame, Random& random) {
  const DepthImage whole = frame.depth;
  for (int v = 0; v < whole.height(); ++v) {
    for (int u = 3; u + 3 < whole.width(); ++u) {
      const float before = whole.at(u - 3, v) > 0 ? whole.at(u - 3, v) : 4.0F;
      const float after = whole.at(u + 3, v) > 0 ? whole.at(u + 3, v) : 4.0F;
      if (std::abs(before - after) > 0.1F) frame.depth.at(u, v) = before + random.uniform() * (after - before);
    }
  }
  return true;
}

bool salt(ingest::Frame& frame, Random& random) {
  for (float& z : frame.depth.values()) {
    if (random.below(10) == 0) z = 0.3F + 4 * random.uniform();
  }
  return true;
}

bool misaligned(ingest::Frame& frame, Random&) {
  const DepthImage whole = frame.depth;
  for (int v = 0; v < whole.height(); ++v) {
    for (int u = 0; u < whole.width(); ++u) frame.depth.at(u, v) = u < 3 ? 0 : whole.at(u - 3, v);
  }
  return true;
}

bool every_third_is_lost(ingest::Frame& frame, Random&) { return frame.index % 3 != 1; }

/// From frame 15 to 25 something 30 cm before the person hides `share` of the picture's height, from below.
Fault hidden(double share) {
  return [share](ingest::Frame& frame, Random&) {
    if (frame.index < 15 || frame.index > 25) return true;
    float nearest = 4;
    int top = frame.labels.height();
    int bottom = 0;
    for (int v = 0; v < frame.labels.height(); ++v) {
      for (int u = 0; u < frame.labels.width(); ++u) {
        if (frame.labels.at(u, v) == 0) continue;
        top = std::min(top, v);
        bottom = std::max(bottom, v);
        if (frame.depth.at(u, v) > 0) nearest = std::min(nearest, frame.depth.at(u, v));
      }
    }
    const int from = static_cast<int>(bottom - share * (bottom - top));
    for (int v = from; v < frame.labels.height(); ++v) {
      for (int u = 0; u < frame.labels.width(); ++u) {
        frame.labels.at(u, v) = 0;
        frame.depth.at(u, v) = nearest - 0.3F;
      }
    }
    return true;
  };
}

class FaultyPerson : public ::testing::TestWithParam<Case> {};

TEST_P(FaultyPerson, IsFollowedAllTheSame) {
  const Followed found = follow(GetParam().fault);
  EXPECT_LT(found.mean_error, GetParam().bound);
  EXPECT_EQ(found.not_tracked, 0);
}

// Found: 5.0, 5.6, 4.8, 4.9, 5.0, 5.0, 5.0, 8.2, 10.7 and 13.8 mm; no frame is lost.
INSTANTIATE_TEST_SUITE_P(Faults, FaultyPerson,
                         ::testing::Values(Case{"none", nothing, 0.008}, Case{"noise", triple_noise, 0.009},
                                           Case{"holes", holes, 0.008}, Case{"flying", flying_pixels, 0.008},
                                           Case{"salt", salt, 0.008}, Case{"misaligned", misaligned, 0.008},
                                           Case{"dropped", every_third_is_lost, 0.008},
                                           Case{"hidden30", hidden(0.3), 0.012}, Case{"hidden60", hidden(0.6), 0.016},
                                           Case{"hidden90", hidden(0.9), 0.021}),
                         [](const auto& test) { return std::string(test.param.name); });

} // namespace
} // namespace kinora::tracking
