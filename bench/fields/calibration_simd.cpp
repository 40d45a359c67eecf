#include "fields/calibration.h"

#include <algorithm>
#include <chrono>
#include <cstdio>

#include "core/large_buffer.h"
#include "fields/network/instruction_set.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fields/calibration_simd.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kinora::bench::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Floating-point operations; `sink` keeps them from being left out.
double multiply_add(long rounds, float* sink) {
  constexpr int kChains = 12;
  const hn::ScalableTag<float> d;
  const auto factor = hn::Set(d, 0.999F);
  const auto add = hn::Set(d, 0.001F);
  hn::Vec<decltype(d)> sums[kChains];
  for (auto& sum : sums) sum = hn::Set(d, *sink);
  for (long i = 0; i < rounds; ++i)
    for (auto& sum : sums) sum = hn::MulAdd(sum, factor, add);
  for (const auto& sum : sums) *sink += hn::GetLane(hn::SumOfLanes(d, sum));
  return 2.0 * kChains * static_cast<double>(hn::Lanes(d)) * static_cast<double>(rounds);
}

/// Sums rows of 8 floats at random places.
void look_up(const float* table, std::uint32_t mask, long rows, float* sink) {
  const hn::CappedTag<float, 8> d;
  auto sum = hn::Zero(d);
  std::uint32_t at = 1;
  for (long i = 0; i < rows; ++i) {
    at = at * 1664525U + 1013904223U;
    const float* row = table + static_cast<std::size_t>((at >> 8) & mask) * 8;
    for (std::size_t k = 0; k < 8; k += hn::Lanes(d)) sum = hn::Add(sum, hn::LoadU(d, row + k));
  }
  *sink += hn::GetLane(hn::SumOfLanes(d, sum));
}

} // namespace kinora::bench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::bench {

HWY_EXPORT(multiply_add);
HWY_EXPORT(look_up);

Calibration calibrate() {
  using Clock = std::chrono::steady_clock;
  const auto seconds = [](Clock::time_point begin) {
    return std::chrono::duration<double>(Clock::now() - begin).count();
  };
  Calibration best;
  volatile float kept = 0;
  float sink = 0.5F;
  constexpr std::uint32_t kRows = 1U << 17;
  LargeBuffer<float> table(std::size_t{kRows} * 8, 1.0F);
  for (int run = 0; run < 5; ++run) {
    Clock::time_point begin = Clock::now();
    const double operations = HWY_DYNAMIC_DISPATCH(multiply_add)(5'000'000, &sink);
    best.fma_gflops = std::max(best.fma_gflops, operations / seconds(begin) / 1e9);
    constexpr long kLookUps = 10'000'000;
    begin = Clock::now();
    HWY_DYNAMIC_DISPATCH(look_up)(table.data(), kRows - 1, kLookUps, &sink);
    best.lines_per_us = std::max(best.lines_per_us, kLookUps / seconds(begin) / 1e6);
  }
  kept = sink;
  static_cast<void>(kept);
  return best;
}

void print_calibration() {
  const Calibration machine = calibrate();
  std::printf("# one core: %.0f GFLOP/s, %.0f look-ups of 32 bytes in 4 MB per microsecond; %s\n", machine.fma_gflops,
              machine.lines_per_us, fields::kernels::instruction_set());
}

} // namespace kinora::bench
#endif
