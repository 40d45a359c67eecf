// The short row of every fuzzer: the same damaged inputs each time.
#include <sys/resource.h>

#include <gtest/gtest.h>

#include "core/error.h"
#include "fuzz/fuzzer.h"
#include "fuzz/mutate.h"

#ifdef __SANITIZE_ADDRESS__
// What is freed must go back, or the sanitizer's own store would count as memory of the parser.
extern "C" const char* __asan_default_options();  // NOLINT(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp)
extern "C" const char* __asan_default_options() { // NOLINT(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp)
  return "quarantine_size_mb=8:thread_local_quarantine_size_kb=64";
}
#endif

namespace kinora::fuzz {
namespace {

/// Of all the memory that the program has taken at once, up to now.
long peak_megabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss / 1024;
}

class Fuzz : public ::testing::TestWithParam<Fuzzer> {};

TEST_P(Fuzz, EveryInputIsReadOrRefused) {
  const Fuzzer& fuzzer = GetParam();
  const std::vector<Bytes> seeds = fuzzer.seeds();
  ASSERT_FALSE(seeds.empty());
  for (const Bytes& seed : seeds) ASSERT_NO_THROW(fuzzer.run(seed)) << "a seed is refused";
  constexpr long kMostMegabytes = 256;
  const long before = peak_megabytes();
  for (int round = 0; round < fuzzer.rounds; ++round) {
    Random random(11, static_cast<std::uint64_t>(round));
    const Bytes input = mutate(seeds[static_cast<std::size_t>(round) % seeds.size()], random);
    try {
      fuzzer.run(input);
    } catch (const Error& error) {
      ASSERT_STRNE(error.what(), "") << "round " << round;
    } catch (const std::exception& fault) {
      FAIL() << "round " << round << ": " << fault.what();
    }
  }
  EXPECT_LT(peak_megabytes() - before, kMostMegabytes);
}

INSTANTIATE_TEST_SUITE_P(All, Fuzz, ::testing::ValuesIn(fuzzers()),
                         [](const auto& chosen) { return std::string(chosen.param.name); });

} // namespace
} // namespace kinora::fuzz
