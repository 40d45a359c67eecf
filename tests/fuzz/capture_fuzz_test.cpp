// Damaged captures: whatever the bytes are, reading ends in frames, skipped frames or one Error.
#include <gtest/gtest.h>

#include "core/error.h"
#include "evaluate/ground_truth.h"
#include "formats/sample_capture.h"
#include "fuzz/mutate.h"
#include "host/plugin_table.h"
#include "ingest/capture/capture.h"

namespace kinora::fuzz {
namespace {

using namespace kinora::test;

constexpr int kRounds = 400;

Bytes bytes_of(const std::string& text) {
  const auto view = std::as_bytes(std::span(text));
  return {view.begin(), view.end()};
}

/// Any Error is fine, any other exception is a fault.
template <class Call> void survive(const Call& call) {
  try {
    call();
  } catch (const Error& error) {
    EXPECT_STRNE(error.what(), "");
  }
}

TEST(CaptureFuzz, DamagedPicturesEndInAnErrorOrAPicture) {
  const Bytes sources[] = {color_bytes(1), depth_bytes(1), jpeg_of(sample_color(24, 20)),
                           encode_png(sample_color(16, 12, 1)), encode_png(sample_color(16, 12, 4))};
  Random random(11);
  for (int round = 0; round < 5 * kRounds; ++round) {
    const Bytes bytes = mutate(sources[round % 5], random);
    survive([&] { decode_color(bytes, "picture"); });
    survive([&] { decode_depth16(bytes, "picture"); });
    survive([&] { decode_labels(bytes, "picture"); });
  }
}

/// Damages one file of a capture at a time and reads all of it.
void read_with_damage(const TemporaryFolder& folder, const fs::path& name, std::uint64_t seed, int rounds) {
  std::ifstream file(folder.path() / name, std::ios::binary);
  const Bytes whole = bytes_of({(std::istreambuf_iterator<char>(file)), {}});
  ASSERT_FALSE(whole.empty()) << name;
  const host::PluginTable plugins = host::PluginTable::builtin();
  Progress progress;
  Random random(seed);
  for (int round = 0; round < rounds; ++round) {
    folder.write(name, mutate(whole, random));
    survive([&] {
      const auto capture = ingest::Capture::open(plugins, folder.path(), {}, progress);
      while (capture->next()) {
      }
    });
    survive([&] { (void)evaluate::GroundTruth::read(folder.path()); });
  }
  folder.write(name, whole);
}

TEST(CaptureFuzz, DamagedTumFoldersNeverCrash) {
  const TemporaryFolder folder;
  write_tum(folder, 3);
  folder.write("groundtruth.txt", "100.0 0 0 0 0 0 0 1\n100.03 1 0 0 0 0 0 1\n100.07 2 0 0 0 0 0 1\n");
  folder.write("labels.json", R"({"2": {"name": "box", "kind": "rigid"}})");
  int seed = 21;
  for (const char* name : {"rgb.txt", "depth.txt", "groundtruth.txt", "intrinsics.json", "labels.json"})
    read_with_damage(folder, name, static_cast<std::uint64_t>(seed++), kRounds / 4);
}

TEST(CaptureFuzz, DamagedMatchFoldersNeverCrash) {
  const TemporaryFolder folder;
  write_3dmatch(folder, 3);
  int seed = 31;
  for (const char* name : {"camera-intrinsics.txt", "frames/frame-000151.pose.txt", "frames/frame-000150.depth.png"})
    read_with_damage(folder, name, static_cast<std::uint64_t>(seed++), kRounds / 4);
}

TEST(CaptureFuzz, DamagedGroundTruthNeverCrashes) {
  const TemporaryFolder folder;
  write_numbered(folder, 1);
  folder.write("cameras.json", R"({"cameras": [{"name": "a", "width": 16, "height": 12, "fx": 20, "fy": 20, "cx": 7.5,
    "cy": 5.5, "camera_to_world": [[1, 0, 0, 5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}]})");
  folder.write("gt/object_pose.txt", "0 1000.0 1 0 0 0.5 0 1 0 0 0 0 1 2 0 0 0 1\n");
  folder.write("gt/object_mesh.obj", "v 0 0 0\nv 1 2 3\n");
  int seed = 41;
  for (const char* name : {"cameras.json", "gt/object_pose.txt", "gt/object_mesh.obj"})
    read_with_damage(folder, name, static_cast<std::uint64_t>(seed++), kRounds / 4);
}

} // namespace
} // namespace kinora::fuzz
