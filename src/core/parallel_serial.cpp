// The loops of parallel.h on the one thread that there is: built instead of parallel.cpp for WebAssembly.
#include "core/parallel.h"

#include <algorithm>

namespace kinora {

void set_thread_count(int /*threads*/) {}

int thread_count() { return 1; }

void parallel_for(std::size_t count, std::size_t chunk_size, const std::function<void(const Chunk&)>& body) {
  for (std::size_t i = 0; i < chunk_count(count, chunk_size); ++i) {
    body({i * chunk_size, std::min(count, (i + 1) * chunk_size), i});
  }
}

} // namespace kinora
