// How much memory this process has, and the most that it has had.
#pragma once

#include <cstddef>
#include <fstream>
#include <string>

namespace kinora::bench {

/// A line of /proc/self/status in megabytes (10⁶ bytes): "VmRSS:" is what is resident, "VmHWM:" the most that was.
inline double megabytes_of(const std::string& line_name) {
  std::ifstream status("/proc/self/status");
  double kibibytes = 0;
  for (std::string word; status >> word;) {
    if (word == line_name) status >> kibibytes;
  }
  return kibibytes * 1024 / 1e6;
}

/// What is resident now becomes the most that was (Linux 4.0).
inline void forget_peak_memory() { std::ofstream("/proc/self/clear_refs") << "5"; }

} // namespace kinora::bench
