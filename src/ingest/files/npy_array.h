// An array in NumPy's file format.
// Source: NumPy's documentation, numpy.lib.format (versions 1.0, 2.0 and 3.0).
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace kinora::ingest {

/// Numbers in C order: the last index runs fastest.
struct NpyArray {
  std::vector<std::size_t> shape;
  std::vector<double> values;
};

/// A whole file in memory: little-endian integers or floats of 4 or 8 bytes, one to three dimensions, C or Fortran
/// order. Safe for untrusted input; memory is bounded by that of `bytes`. Throws Error(kCorruptInput), naming `source`:
/// for damage, data that are too short or too long, pickled objects and any other type, and numbers that are not
/// finite.
NpyArray parse_npy(std::span<const std::byte> bytes, const std::string& source);

} // namespace kinora::ingest
