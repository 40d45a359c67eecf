// Parallel loops over fixed chunks. The chunks depend on the sizes alone, never on the number of threads,
// so that whatever is merged in chunk order has the same bits for every number of threads.
#pragma once

#include <cstddef>
#include <functional>

namespace kinora {

/// Half-open range of one chunk.
struct Chunk {
  std::size_t begin;
  std::size_t end;
  std::size_t index; ///< begin / chunk size
};

/// Threads that every later loop may use; 0 means one per core. Not to be called while a loop runs.
void set_thread_count(int threads);
int thread_count();

/// Calls `body` once for each chunk of [0, count), in any order, on any thread. Chunks do not overlap; the last may
/// be shorter. An exception of a body is thrown again here after the loop has stopped. Loops may be nested.
void parallel_for(std::size_t count, std::size_t chunk_size, const std::function<void(const Chunk&)>& body);

/// While it lives, loops that this thread starts run on it alone. For work beside other work that goes first.
class SerialLoops {
public:
  SerialLoops();
  ~SerialLoops();
  SerialLoops(const SerialLoops&) = delete;
  SerialLoops& operator=(const SerialLoops&) = delete;

private:
  bool before_;
};

/// From now on the system gives this thread less time than others where there are too few cores.
void yield_to_other_threads();

constexpr std::size_t chunk_count(std::size_t count, std::size_t chunk_size) {
  return (count + chunk_size - 1) / chunk_size;
}

} // namespace kinora
