// How much memory a file may make its reader allocate.
#pragma once

#include <cstdint>
#include <string>

#include <fmt/format.h>

#include "core/error.h"

namespace kinora::clip {

/// Counts what the numbers in a file ask for. A small file may ask for a quarter of a gigabyte (a field whose table is
/// mostly untouched is large in memory and small on disk), a large one for 64 times its size.
class AllocationBudget {
public:
  explicit AllocationBudget(std::uint64_t file_bytes) : left_(file_bytes * 64 + (std::uint64_t{256} << 20)) {}

  /// False, and nothing taken, if that much is not left.
  bool try_take(std::uint64_t bytes) {
    if (bytes > left_) return false;
    left_ -= bytes;
    return true;
  }
  /// Throws Error(kCorruptInput) naming `location` if that much is not left.
  void take(std::uint64_t bytes, const std::string& location) {
    if (try_take(bytes)) return;
    throw Error(
        ErrorCode::kCorruptInput,
        fmt::format("{}: asks for {} MB of memory, which a file of this size cannot need", location, bytes >> 20));
  }

private:
  std::uint64_t left_;
};

} // namespace kinora::clip
