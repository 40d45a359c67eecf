// Sounds that are made for tests.
#pragma once

#include <cmath>
#include <cstdint>
#include <fstream>
#include <numbers>
#include <string>
#include <vector>

namespace kinora::test {

/// A tone of 440 Hz, silent but for [begin, end) seconds, as a WAVE file of 16 bits. Returns its samples, all channels
/// alike.
inline std::vector<std::int16_t> write_tone(const std::string& path, double seconds, double begin, double end,
                                            int rate = 16'000, int channels = 1) {
  std::vector<std::int16_t> samples;
  for (int i = 0; i < static_cast<int>(seconds * rate); ++i) {
    const double t = i / static_cast<double>(rate);
    const double value = t >= begin && t < end ? std::sin(2 * std::numbers::pi * 440 * t) : 0;
    for (int c = 0; c < channels; ++c) samples.push_back(static_cast<std::int16_t>(std::lround(value * 16'000)));
  }
  std::ofstream file(path, std::ios::binary);
  const auto put = [&file](std::uint32_t value, int bytes) { // little endian
    for (int b = 0; b < bytes; ++b) file.put(static_cast<char>(value >> (8 * b)));
  };
  const auto data_bytes = static_cast<std::uint32_t>(samples.size() * 2);
  const auto frame = static_cast<std::uint32_t>(2 * channels);
  file << "RIFF";
  put(36 + data_bytes, 4);
  file << "WAVEfmt ";
  put(16, 4);
  put(1, 2);
  put(static_cast<std::uint32_t>(channels), 2);
  put(static_cast<std::uint32_t>(rate), 4);
  put(static_cast<std::uint32_t>(rate) * frame, 4);
  put(frame, 2);
  put(16, 2);
  file << "data";
  put(data_bytes, 4);
  for (const std::int16_t sample : samples) put(static_cast<std::uint16_t>(sample), 2);
  return samples;
}

} // namespace kinora::test
