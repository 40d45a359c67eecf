// The loops of parallel.h on plain threads: built instead of parallel.cpp under the thread sanitizer, which cannot see
// inside the TBB library and would report each of its hand-overs as a race.
#include "core/parallel.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace kinora {
namespace {

int hardware_threads() { return std::max(1, static_cast<int>(std::thread::hardware_concurrency())); }

int& threads_to_use() {
  static int threads = hardware_threads();
  return threads;
}

thread_local bool is_serial = false;

} // namespace

SerialLoops::SerialLoops() : before_(std::exchange(is_serial, true)) {}
SerialLoops::~SerialLoops() { is_serial = before_; }

void yield_to_other_threads() {} // it would only change when things happen

void set_thread_count(int threads) { threads_to_use() = threads > 0 ? threads : hardware_threads(); }

int thread_count() { return threads_to_use(); }

void parallel_for(std::size_t count, std::size_t chunk_size, const std::function<void(const Chunk&)>& body) {
  const std::size_t chunks = chunk_count(count, chunk_size);
  std::atomic<std::size_t> next = 0;
  std::mutex mutex;
  std::exception_ptr thrown;
  const auto work = [&] {
    // Relaxed: taking a chunk must not order the bodies, or it would hide their races from the sanitizer.
    for (std::size_t i = next.fetch_add(1, std::memory_order_relaxed); i < chunks;
         i = next.fetch_add(1, std::memory_order_relaxed)) {
      try {
        body({i * chunk_size, std::min(count, (i + 1) * chunk_size), i});
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!thrown) thrown = std::current_exception();
        next.store(chunks, std::memory_order_relaxed);
      }
    }
  };
  const std::size_t threads = is_serial ? 1 : std::min(chunks, static_cast<std::size_t>(thread_count()));
  std::vector<std::jthread> helpers;
  for (std::size_t i = 1; i < threads; ++i) helpers.emplace_back(work);
  work();
  helpers.clear();
  if (thrown) std::rethrow_exception(thrown);
}

} // namespace kinora
