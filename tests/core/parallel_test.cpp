#include "core/parallel.h"

#include <atomic>
#include <mutex>
#include <numeric>
#include <set>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include "core/random.h"

namespace kinora {
namespace {

constexpr std::array<int, 3> kThreadCounts = {1, 2, 7};

class Parallel : public ::testing::Test {
protected:
  void TearDown() override { set_thread_count(0); }
};

TEST_F(Parallel, CoversTheRangeOnceWithTheSameChunksForEveryThreadCount) {
  for (const std::size_t count :
       {std::size_t{1}, std::size_t{9}, std::size_t{10}, std::size_t{11}, std::size_t{1000}}) {
    std::set<std::array<std::size_t, 3>> expected;
    for (std::size_t i = 0; i * 10 < count; ++i) expected.insert({i * 10, std::min(count, i * 10 + 10), i});
    EXPECT_EQ(expected.size(), chunk_count(count, 10));
    for (const int threads : kThreadCounts) {
      set_thread_count(threads);
      std::mutex mutex;
      std::vector<std::array<std::size_t, 3>> found;
      parallel_for(count, 10, [&](const Chunk& chunk) {
        const std::lock_guard lock(mutex);
        found.push_back({chunk.begin, chunk.end, chunk.index});
      });
      EXPECT_EQ(found.size(), expected.size()) << threads << " threads";
      EXPECT_EQ(std::set(found.begin(), found.end()), expected) << threads << " threads";
    }
  }
}

TEST_F(Parallel, CallsNothingForAnEmptyRange) {
  for (const int threads : kThreadCounts) {
    set_thread_count(threads);
    std::atomic<int> calls = 0;
    parallel_for(0, 16, [&](const Chunk&) { ++calls; });
    EXPECT_EQ(calls, 0);
  }
}

// A sum of floats depends on the order of its terms: equal bits show that chunks are merged in order.
float sum_of_noise(std::size_t count) {
  constexpr std::size_t kChunk = 64;
  std::vector<float> partial(chunk_count(count, kChunk), 0.0F);
  parallel_for(count, kChunk, [&](const Chunk& chunk) {
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) partial[chunk.index] += Random(7, i).uniform() * 1e3F;
  });
  return std::accumulate(partial.begin(), partial.end(), 0.0F);
}

TEST_F(Parallel, GivesTheSameBitsForOneTwoAndSevenThreads) {
  set_thread_count(1);
  const float expected = sum_of_noise(10007);
  for (const int threads : kThreadCounts) {
    set_thread_count(threads);
    EXPECT_EQ(sum_of_noise(10007), expected) << threads << " threads";
  }
}

TEST_F(Parallel, ThrowsWhatABodyThrows) {
  for (const int threads : kThreadCounts) {
    set_thread_count(threads);
    const auto loop = [] {
      parallel_for(100, 1, [](const Chunk& chunk) {
        if (chunk.index == 42) throw std::runtime_error("chunk 42");
      });
    };
    try {
      loop();
      ADD_FAILURE() << "nothing was thrown with " << threads << " threads";
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "chunk 42");
    }
  }
}

TEST_F(Parallel, WorksAgainAfterAnException) {
  set_thread_count(2);
  EXPECT_THROW(parallel_for(10, 1, [](const Chunk&) { throw std::runtime_error("stop"); }), std::runtime_error);
  std::atomic<std::size_t> seen = 0;
  parallel_for(1000, 7, [&](const Chunk& chunk) { seen += chunk.end - chunk.begin; });
  EXPECT_EQ(seen, 1000U);
}

TEST_F(Parallel, MayBeNested) {
  for (const int threads : kThreadCounts) {
    set_thread_count(threads);
    std::vector<std::size_t> cells(20 * 30, 0);
    parallel_for(20, 3, [&](const Chunk& rows) {
      for (std::size_t row = rows.begin; row < rows.end; ++row) {
        parallel_for(30, 4, [&, row](const Chunk& columns) {
          for (std::size_t column = columns.begin; column < columns.end; ++column) cells[row * 30 + column] += row;
        });
      }
    });
    for (std::size_t i = 0; i < cells.size(); ++i) ASSERT_EQ(cells[i], i / 30) << threads << " threads";
  }
}

TEST_F(Parallel, CallerSeesWhatTheBodiesWrote) {
  set_thread_count(7);
  std::vector<int> values(5000, 0);
  for (int round = 1; round <= 20; ++round) {
    parallel_for(values.size(), 11, [&](const Chunk& chunk) {
      for (std::size_t i = chunk.begin; i < chunk.end; ++i) values[i] += round;
    });
  }
  EXPECT_EQ(std::accumulate(values.begin(), values.end(), 0), 5000 * 210);
}

TEST_F(Parallel, ThreadCountIsWhatWasSet) {
  set_thread_count(3);
  EXPECT_EQ(thread_count(), 3);
  set_thread_count(0);
  EXPECT_GE(thread_count(), 1);
}

} // namespace
} // namespace kinora
