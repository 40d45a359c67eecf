// What the machine can do at this moment, so that numbers of different runs can be compared.
#pragma once

namespace kinora::bench {

struct Calibration {
  double fma_gflops = 0;   ///< one core, floats in the widest vectors
  double lines_per_us = 0; ///< look-ups of 32 bytes at random places of 4 MB, one core
};

/// Takes about half a second; on the calling thread.
Calibration calibrate();

/// Calibrates, and prints the line that benches begin with: what was found, and with which instructions.
void print_calibration();

} // namespace kinora::bench
