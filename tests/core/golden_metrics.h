// Made by make_golden_metrics.py from the reference script of the image metrics: do not edit.
#pragma once

#include "core/metrics.h"

namespace kinora {

struct GoldenMetrics {
  const char* name;
  int width;
  int height;
  int channels;
  const char* mask;
  int amplitude;
  const char* alpha;
  ImageMetrics expected;
};

// clang-format off
constexpr GoldenMetrics kGoldenMetrics[] = {
    {"rgba_with_mask", 64, 48, 4, "disc", 8, "mixed",
     {9.310222, 0.091556, 9.071781, 0.060437, 15.503793, 61.576955, 0.176471}},
    {"rgba_without_mask", 64, 48, 4, "none", 8, "mixed",
     {9.074745, 0.197793, 9.074745, 0.197793, 13.953824, 66.007704, 0.500977}},
    {"rgb_with_mask", 64, 48, 3, "disc", 20, "mixed",
     {6.213904, 0.190697, 5.419214, 0.125733, 27.003941, 94.243128, 0.202148}},
    {"rgb_without_mask", 64, 48, 3, "none", 60, "mixed",
     {17.499020, 0.360139, 17.499020, 0.360139, 17.499020, 29.055556, 1.000000}},
    {"box_cut_by_the_border", 33, 21, 4, "corner", 8, "mixed",
     {12.472675, -0.006291, 8.383157, -0.001161, 17.862748, 46.430556, 0.017910}},
    {"tiny_rgba_with_mask", 5, 4, 4, "disc", 8, "mixed",
     {13.805868, -0.224700, 13.805868, -0.224700, 0.000000, 36.700000, 0.000000}},
    {"tiny_rgba_without_mask", 5, 4, 4, "none", 8, "mixed",
     {13.413341, 0.126346, 13.413341, 0.126346, 22.044652, 40.366667, 0.400000}},
    {"tiny_rgb_without_mask", 5, 4, 3, "none", 8, "mixed",
     {34.079618, 0.920651, 34.079618, 0.920651, 34.079618, 4.316667, 1.000000}},
    {"three_rows", 40, 3, 4, "disc", 8, "mixed",
     {7.822941, -0.023362, 8.639586, -0.014043, 13.110062, 81.362007, 0.256410}},
    {"identical_without_mask", 24, 24, 3, "none", 0, "mixed",
     {100.000000, 1.000000, 100.000000, 1.000000, 100.000000, 0.000000, 1.000000}},
    {"identical_inside_mask", 24, 24, 4, "disc", 0, "as_mask",
     {100.000000, 1.000000, 100.000000, 1.000000, 100.000000, 0.000000, 1.000000}},
    {"nothing_drawn", 24, 24, 4, "disc", 8, "half",
     {10.501702, 0.036570, 10.501702, 0.036570, 0.000000, 71.240162, 0.000000}},
};
// clang-format on

} // namespace kinora
