// The short row of every fuzzer: the same damaged inputs each time.
#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>

#include <gtest/gtest.h>

#include "core/error.h"
#include "fuzz/fuzzer.h"
#include "fuzz/mutate.h"
#include "host/plugin_table.h"

#ifdef __SANITIZE_ADDRESS__
// What is freed must go back, or the sanitizer's own store would count as memory of the parser.
extern "C" const char* __asan_default_options();  // NOLINT(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp)
extern "C" const char* __asan_default_options() { // NOLINT(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp)
  return "quarantine_size_mb=8:thread_local_quarantine_size_kb=64";
}
#endif

namespace {
std::atomic<std::size_t> largest_block; // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)
}

#ifndef __SANITIZE_ADDRESS__
/// Which FFmpeg's libraries take all of their memory by; a block that is never touched does not show otherwise.
extern "C" int posix_memalign(void** memory, std::size_t alignment, std::size_t bytes) noexcept {
  largest_block = std::max(largest_block.load(), bytes);
  *memory = std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
  return *memory == nullptr ? ENOMEM : 0;
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

/// What libFuzzer found once: found/NAME of each fuzzer.
TEST_P(Fuzz, WhatWasFoundOnceIsReadOrRefused) {
  constexpr std::size_t kMostBytes = std::size_t{256} << 20;
  const std::filesystem::path folder = std::filesystem::path(KINORA_FUZZ_FOUND) / GetParam().name;
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "nothing was found";
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    std::ifstream file(entry.path(), std::ios::binary);
    const Bytes input = bytes_of({std::istreambuf_iterator<char>(file), {}});
    largest_block = 0;
    try {
      GetParam().run(input);
    } catch (const Error& error) {
      EXPECT_STRNE(error.what(), "out of memory") << entry.path();
    }
    EXPECT_LT(largest_block, kMostBytes) << entry.path();
  }
}

INSTANTIATE_TEST_SUITE_P(All, Fuzz, ::testing::ValuesIn(fuzzers()),
                         [](const auto& chosen) { return std::string(chosen.param.name); });

/// Of a format that reads captures: the fuzzers of its files. Pictures are all formats'.
const std::map<std::string, std::vector<std::string>> kFuzzersOf = {
    {"tum-rgbd", {"tum_list", "associations", "trajectory", "calibration"}},
    {"numbered-folder", {"labels_json", "trajectory_log"}},
    {"3dmatch", {"camera_matrix", "pose_file"}},
    {"m3t", {"yaml"}},
    {"transforms", {"transforms"}},
    {"kinora-recording", {"recording"}},
    {"kinora-clip", {"container", "clip", "clip_capture"}},
    {"stray-scanner", {"odometry", "stray_matrix", "stray_video"}},
    {"video-pair", {"depth_video"}},
    {"azure-kinect", {"azure_kinect", "kinect_calibration"}},
    {"record3d", {"record3d", "record3d_metadata", "lzfse"}},
    {"ros-bag", {"ros_bag", "rvl"}},
    {"mcap", {"mcap", "rvl"}},
    {"exr-sequence", {"exr"}},
    {"oni", {"oni"}},
    {"gltf-scene", {"gltf"}}};

TEST(Fuzzers, AreThereForEveryReader) {
  std::set<std::string> names;
  for (const Fuzzer& fuzzer : fuzzers()) names.insert(fuzzer.name);
  const host::PluginTable table = host::PluginTable::builtin();
  for (const host::FormatEntry& entry : table.formats()) {
    if (!host::supports(*entry.format, KINORA_READS_FRAMES) || host::supports(*entry.format, KINORA_READS_DEVICE))
      continue;
    const auto found = kFuzzersOf.find(entry.format->name);
    ASSERT_NE(found, kFuzzersOf.end()) << entry.format->name;
    for (const std::string& name : found->second) EXPECT_TRUE(names.contains(name)) << name;
  }
}

} // namespace
} // namespace kinora::fuzz
