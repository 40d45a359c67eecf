// What core has in lanes is what it has for single numbers.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/lanes_simd_test.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>
// after highway.h
#include "core/free_space_simd.h"
#include "core/robust_cost_simd.h"
#include "core/sensor_noise_simd.h"

#ifndef KINORA_TESTS_CORE_LANES_ONCE
#define KINORA_TESTS_CORE_LANES_ONCE
namespace kinora {

constexpr DepthMargin kMargin{0.03, 3};
constexpr float kThreshold = 1.5F;

/// As many of each as lanes can be filled with.
struct Numbers {
  static constexpr std::size_t kCount = 1024;
  float z[kCount], other[kCount]; ///< another depth, a cosine or a residual
  float first[kCount], second[kCount];
};

} // namespace kinora
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora::HWY_NAMESPACE {
using namespace vectors::HWY_NAMESPACE;
namespace hn = hwy::HWY_NAMESPACE;

/// `of`: both results of z and the other number.
template <class Of> HWY_INLINE void for_all(Numbers& n, const Of& of) {
  const Floats df;
  for (std::size_t i = 0; i < Numbers::kCount; i += hn::Lanes(df)) {
    F first = zero();
    F second = zero();
    of(hn::LoadU(df, n.z + i), hn::LoadU(df, n.other + i), first, second);
    hn::StoreU(first, df, n.first + i);
    hn::StoreU(second, df, n.second + i);
  }
}

void sigmas(Numbers& n) {
  for_all(n, [](F z, F cosine, F& sigma, F& across) {
    sigma = depth_sigma(z);
    across = depth_sigma_across(z, cosine);
  });
}

void margins(Numbers& n) {
  for_all(n, [](F z, F measured, F& margin, F& hidden) {
    margin = margin_at(kMargin, z);
    hidden = hn::IfThenElseZero(is_occluded(z, measured, kMargin), constant(1));
  });
}

void hubers(Numbers& n) {
  const HuberLanes huber(kThreshold);
  for_all(n, [&](F, F r, F& cost, F& weight) {
    cost = huber.cost(r);
    weight = huber.weight(r);
  });
}

} // namespace kinora::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <memory>

#include "core/random.h"
#include "core/robust_cost.h"
#include "support/every_instruction_set.h"

namespace kinora {
namespace {

HWY_EXPORT(sigmas);
HWY_EXPORT(margins);
HWY_EXPORT(hubers);

constexpr float kRounding = 1e-6F; // of a number

/// Depths from 0.2 to 8 m, and others from `low` to `high`.
std::unique_ptr<Numbers> some_numbers(float low, float high) {
  auto numbers = std::make_unique<Numbers>();
  Random random(3);
  for (std::size_t i = 0; i < Numbers::kCount; ++i) {
    numbers->z[i] = 0.2F + 7.8F * random.uniform();
    numbers->other[i] = low + (high - low) * random.uniform();
  }
  return numbers;
}

void expect_near(float found, double expected) {
  EXPECT_NEAR(found, expected, kRounding * std::abs(expected) + kRounding * 1e-3);
}

class Lanes : public OnEveryInstructionSet {};

TEST_P(Lanes, HaveTheSensorsNoise) {
  const auto n = some_numbers(0, 1);
  HWY_DYNAMIC_DISPATCH(sigmas)(*n);
  for (std::size_t i = 0; i < Numbers::kCount; ++i) {
    expect_near(n->first[i], kSensorNoise.sigma(n->z[i]));
    expect_near(n->second[i], kSensorNoise.sigma_across(n->z[i], n->other[i]));
  }
}

TEST_P(Lanes, HavePointsHiddenByWhatIsMeasured) {
  const auto n = some_numbers(0, 8);
  for (std::size_t i = 0; i < Numbers::kCount; i += 5) n->other[i] = 0;
  HWY_DYNAMIC_DISPATCH(margins)(*n);
  for (std::size_t i = 0; i < Numbers::kCount; ++i) {
    expect_near(n->first[i], kMargin.at(n->z[i]));
    EXPECT_EQ(n->second[i] != 0, is_occluded(n->z[i], n->other[i], kMargin)) << n->z[i] << ' ' << n->other[i];
  }
}

TEST_P(Lanes, HaveHubersCost) {
  const auto n = some_numbers(-6, 6);
  HWY_DYNAMIC_DISPATCH(hubers)(*n);
  for (std::size_t i = 0; i < Numbers::kCount; ++i) {
    const Huber huber{kThreshold};
    expect_near(n->first[i], huber.cost(n->other[i]));
    expect_near(n->second[i], huber.weight(n->other[i]));
  }
}

INSTANTIATE_TEST_SUITE_P(Sets, Lanes, every_instruction_set(), name_of_set);

} // namespace
} // namespace kinora
#endif
