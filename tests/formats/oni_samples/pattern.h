// What the simulated OpenNI camera sees. Twelve frames: depth with steps, holes, even parts and noise, and colour.
#pragma once

#include <cstdint>

namespace kinora::test::oni {

constexpr int kWidth = 32;
constexpr int kHeight = 24;
constexpr int kFrames = 12;
constexpr double kFramesPerSecond = 30;
constexpr float kHorizontalView = 1.0F; // radians
constexpr float kVerticalView = 0.78F;

/// Millimetres.
inline std::uint16_t depth_at(int u, int v, int frame) {
  if ((u + 2 * v + frame) % 11 == 0) return 0;
  if (u >= 20) return static_cast<std::uint16_t>(4000 + 100 * frame);
  return static_cast<std::uint16_t>(1000 + 10 * frame + 3 * u + 40 * (v / 8) + (31 * u + 17 * v) % 5);
}

inline std::uint8_t color_at(int u, int v, int channel, int frame) {
  return static_cast<std::uint8_t>(15 * frame + (channel == 0 ? u : channel == 1 ? 2 * v : 5));
}

} // namespace kinora::test::oni
