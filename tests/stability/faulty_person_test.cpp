// A person seen by a sensor that fails, frames that are lost, and things that stand before him.
#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include <gtest/gtest.h>

#include "core/random.h"
#include "core/sensor_noise.h"
#include "ingest/depth/depth_cleaning.h"
#include "tracking/body/person_camera.h"
#include "tracking/deforming/deforming_tracker.h"
#include "tracking/scenes/seen_errors.h"

namespace kinora::tracking {
namespace {

constexpr int kFrames = 40;
constexpr std::size_t kPoints = 200;
constexpr testing::PersonCamera kCamera{320, 240, 262.5};

enum class Fate {
  kArrives,
  kIsLost,
  kIsReplaced ///< by the one before, once more
};
/// What becomes of a frame and of its depth, before that is cleaned.
using Fault = std::function<Fate(ingest::Frame&, Random&)>;

struct Case {
  const char* name;
  Fault fault;
  double bound; ///< metres, of the mean error of seen points
};

struct Followed {
  int not_tracked = 0;
  double mean_error = 0; ///< metres, of points while they are seen
};

Followed follow(const Fault& fault) {
  testing::PersonScene scene = testing::person_scene("clap");
  scene.frames = kFrames;
  DeformingTracker tracker(1);
  Followed result;
  std::vector<int> numbers; // of the frames that arrive
  ingest::Frame shown;
  for (int i = 0; i < kFrames; ++i) {
    ingest::Frame next = testing::see_person(scene, i, kCamera);
    Random random(7, static_cast<std::uint64_t>(i));
    const Fate fate = fault(next, random);
    if (fate == Fate::kIsLost) continue;
    if (fate == Fate::kArrives) {
      shown = std::move(next);
      shown.clean_depth = ingest::clean_depth(shown.depth, shown.camera.intrinsics);
    }
    shown.index = i;
    shown.time = i / testing::kSceneRate;
    numbers.push_back(fate == Fate::kArrives ? i : -1);
    if (tracker.track(shown).health != motion::Health::kTracked) ++result.not_tracked;
  }
  result.mean_error =
      testing::seen_errors(testing::track_person(scene, kPoints, kCamera), tracker.motion(), numbers).mean;
  return result;
}

Fate nothing(ingest::Frame&, Random&) { return Fate::kArrives; }

Fate triple_noise(ingest::Frame& frame, Random& random) {
  for (float& z : frame.depth.values()) {
    if (z > 0) z += static_cast<float>(std::sqrt(8.0) * kSensorNoise.sigma(z) * random.normal());
  }
  return Fate::kArrives;
}

/// A quarter of the picture, in squares of five pixels.
Fate holes(ingest::Frame& frame, Random& random) {
  constexpr int kSide = 5;
  for (int v = 0; v < frame.depth.height(); v += kSide) {
    for (int u = 0; u < frame.depth.width(); u += kSide) {
      if (random.below(4) > 0) continue;
      for (int y = v; y < std::min(v + kSide, frame.depth.height()); ++y) {
        for (int x = u; x < std::min(u + kSide, frame.depth.width()); ++x) frame.depth.at(x, y) = 0;
      }
    }
  }
  return Fate::kArrives;
}

/// Three pixels on either side of every jump lie anywhere between.
Fate flying_pixels(ingest::Frame& frame, Random& random) {
  const DepthImage whole = frame.depth;
  for (int v = 0; v < whole.height(); ++v) {
    for (int u = 3; u + 3 < whole.width(); ++u) {
      const float before = whole.at(u - 3, v) > 0 ? whole.at(u - 3, v) : 4.0F;
      const float after = whole.at(u + 3, v) > 0 ? whole.at(u + 3, v) : 4.0F;
      if (std::abs(before - after) > 0.1F) frame.depth.at(u, v) = before + random.uniform() * (after - before);
    }
  }
  return Fate::kArrives;
}

Fate salt(ingest::Frame& frame, Random& random) {
  for (float& z : frame.depth.values()) {
    if (random.below(10) == 0) z = 0.3F + 4 * random.uniform();
  }
  return Fate::kArrives;
}

Fate misaligned(ingest::Frame& frame, Random&) {
  const DepthImage whole = frame.depth;
  for (int v = 0; v < whole.height(); ++v) {
    for (int u = 0; u < whole.width(); ++u) frame.depth.at(u, v) = u < 3 ? 0 : whole.at(u - 3, v);
  }
  return Fate::kArrives;
}

Fate every_third_is_lost(ingest::Frame& frame, Random&) {
  return frame.index % 3 == 1 ? Fate::kIsLost : Fate::kArrives;
}

Fate every_third_is_the_one_before(ingest::Frame& frame, Random&) {
  return frame.index % 3 == 1 ? Fate::kIsReplaced : Fate::kArrives;
}

/// From frame 15 to 25 something 30 cm before the person hides `share` of the picture's height, from below.
Fault hidden(double share) {
  return [share](ingest::Frame& frame, Random&) {
    if (frame.index < 15 || frame.index > 25) return Fate::kArrives;
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
    return Fate::kArrives;
  };
}

class FaultyPerson : public ::testing::TestWithParam<Case> {};

TEST_P(FaultyPerson, IsFollowedAllTheSame) {
  const Followed found = follow(GetParam().fault);
  EXPECT_LT(found.mean_error, GetParam().bound);
  EXPECT_EQ(found.not_tracked, 0);
}

// Found: 5.1, 13.4, 6.8, 11.2, 6.0, 5.9, 5.1, 5.9, 8.7, 10.4 and 13.2 mm; bounds are half as much again.
INSTANTIATE_TEST_SUITE_P(Faults, FaultyPerson,
                         ::testing::Values(Case{"none", nothing, 0.008}, Case{"noise", triple_noise, 0.022},
                                           Case{"holes", holes, 0.011}, Case{"flying", flying_pixels, 0.017},
                                           Case{"salt", salt, 0.009}, Case{"misaligned", misaligned, 0.009},
                                           Case{"dropped", every_third_is_lost, 0.008},
                                           Case{"repeated", every_third_is_the_one_before, 0.009},
                                           Case{"hidden30", hidden(0.3), 0.013}, Case{"hidden60", hidden(0.6), 0.016},
                                           Case{"hidden90", hidden(0.9), 0.021}),
                         [](const auto& test) { return std::string(test.param.name); });

// Who reads a capture says that its unit is in doubt (ingest/depth_unit.h); here kilometres and millimetres are nobody.
TEST(FaultyPerson, InTheWrongUnitIsNobody) {
  for (const float unit : {1000.0F, 0.001F}) {
    DeformingTracker tracker(1);
    for (int i = 0; i < 3; ++i) {
      ingest::Frame frame = testing::see_person(testing::person_scene("clap"), i, kCamera);
      for (float& z : frame.depth.values()) z *= unit;
      frame.clean_depth = ingest::clean_depth(frame.depth, frame.camera.intrinsics);
      EXPECT_EQ(tracker.track(frame).health, motion::Health::kLost) << unit;
    }
  }
}

} // namespace
} // namespace kinora::tracking
