#include "core/parallel.h"

#include <algorithm>
#include <memory>
#include <thread>
#include <utility>

#include <sys/resource.h>
#include <unistd.h>

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

namespace kinora {
namespace {

struct Pool {
  int threads = std::max(1, oneapi::tbb::info::default_concurrency());
  std::unique_ptr<oneapi::tbb::global_control> limit;
  std::unique_ptr<oneapi::tbb::task_arena> arena;
};

thread_local bool is_serial = false;

Pool& pool() {
  static Pool instance;
  return instance;
}

} // namespace

void set_thread_count(int threads) {
  Pool& p = pool();
  p.threads = threads > 0 ? threads : std::max(1, oneapi::tbb::info::default_concurrency());
  p.arena.reset();
  p.limit.reset();
  p.limit = std::make_unique<oneapi::tbb::global_control>(oneapi::tbb::global_control::max_allowed_parallelism,
                                                          static_cast<std::size_t>(p.threads));
  p.arena = std::make_unique<oneapi::tbb::task_arena>(p.threads);
}

SerialLoops::SerialLoops() : before_(std::exchange(is_serial, true)) {}
SerialLoops::~SerialLoops() { is_serial = before_; }

void yield_to_other_threads() {
  constexpr int kNice = 5;
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNice); // Linux: of the thread. A wish, that may be refused
}

int thread_count() { return pool().threads; }

void parallel_for(std::size_t count, std::size_t chunk_size, const std::function<void(const Chunk&)>& body) {
  const std::size_t chunks = chunk_count(count, chunk_size);
  const auto run = [&](std::size_t index) {
    body({index * chunk_size, std::min(count, (index + 1) * chunk_size), index});
  };
  if (chunks <= 1 || is_serial || pool().threads == 1) {
    for (std::size_t i = 0; i < chunks; ++i) run(i);
    return;
  }
  const auto loop = [&] { oneapi::tbb::parallel_for(std::size_t{0}, chunks, run, oneapi::tbb::simple_partitioner{}); };
  if (pool().arena) {
    pool().arena->execute(loop);
  } else {
    loop();
  }
}

} // namespace kinora
