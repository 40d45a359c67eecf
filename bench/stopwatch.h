// How long something takes, on the wall and of the processor.
#pragma once

#include <chrono>
#include <ctime>

namespace kinora::bench {

class Stopwatch {
public:
  double milliseconds() const {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start_).count();
  }
  /// Of all threads of the program.
  double processor_milliseconds() const {
    return 1e3 * static_cast<double>(std::clock() - processor_start_) / CLOCKS_PER_SEC;
  }

private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::clock_t processor_start_ = std::clock();
};

} // namespace kinora::bench
