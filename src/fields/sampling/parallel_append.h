// Lists that are filled on all threads.
#pragma once

#include <vector>

#include "core/large_buffer.h"
#include "core/parallel.h"

namespace kinora::fields {

/// Filled chunk by chunk and kept in the order of the chunks.
template <class T> class ParallelAppend {
public:
  /// Calls body(chunk, part) for chunks of [0, count).
  template <class Body> void append(std::size_t count, const Body& body) {
    constexpr std::size_t kChunk = 2048;
    const std::size_t first = parts_.size();
    parts_.resize(first + chunk_count(count, kChunk));
    parallel_for(count, kChunk, [&](const Chunk& chunk) { body(chunk, parts_[first + chunk.index]); });
  }

  LargeBuffer<T> joined() {
    std::size_t size = 0;
    for (const auto& part : parts_) size += part.size();
    LargeBuffer<T> all;
    all.reserve(size);
    for (auto& part : parts_) {
      all.insert(all.end(), part.begin(), part.end());
      part = {};
    }
    return all;
  }

private:
  std::vector<std::vector<T>> parts_;
};

} // namespace kinora::fields
