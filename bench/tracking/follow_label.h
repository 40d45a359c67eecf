// What benches share that follow one label of a capture.
#pragma once

#include <algorithm>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

namespace kinora::bench {

/// 0 without values.
inline double at_fraction(std::vector<double> values, double fraction) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1, static_cast<std::size_t>(fraction * static_cast<double>(values.size())))];
}

/// The program: `BENCH CAPTURE [LABEL]` calls run(capture, label). Returns its exit code.
template <class Run> int follow_label(int argc, char** argv, int label, const Run& run) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: %s CAPTURE [LABEL]\n", argv[0]);
    return 2;
  }
  try {
    run(argv[1], argc > 2 ? std::stoi(argv[2]) : label);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}

} // namespace kinora::bench
