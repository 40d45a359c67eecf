// Files with random contents, from a seed, and what must be read back from them.
#pragma once

#include "container/writer.h"
#include "core/random.h"

namespace kinora::container::testing {

struct SampleFile {
  FileHead head;
  std::vector<Payload> payloads;
};

inline Bytes random_bytes(Random& random, std::size_t size) {
  Bytes bytes(size);
  for (std::byte& b : bytes) b = static_cast<std::byte>(random.below(256));
  return bytes;
}

inline SampleFile sample_file(std::uint64_t seed, std::size_t payload_count, std::size_t largest_payload) {
  Random random(seed);
  SampleFile sample;
  sample.head.kind = "clip";
  const std::uint32_t track_count = 1 + random.below(5);
  for (std::uint32_t t = 0; t < track_count; ++t) {
    const auto id = static_cast<std::uint16_t>(t * 7919 + random.below(7919));
    sample.head.tracks.push_back({id, t % 2 == 0 ? "S_KINORA/FIELD" : "S_KINORA/MOTION", "trąck " + std::to_string(t),
                                  random_bytes(random, random.below(40))});
  }
  for (std::uint32_t a = 0; a < random.below(4); ++a) {
    sample.head.attachments.push_back({"file" + std::to_string(a) + ".json", "application/json", "A description",
                                       random_bytes(random, random.below(3000))});
  }
  sample.head.tags = {{"TITLE", "Ärger im Haus"}};
  std::int64_t time = 0;
  for (std::size_t i = 0; i < payload_count; ++i) {
    if (random.below(3) > 0) time += random.below(random.below(10) == 0 ? 4'000'000'000U : 50'000'000U);
    const std::size_t size = random.below(5) == 0 ? 0 : random.below(static_cast<std::uint32_t>(largest_payload));
    sample.payloads.push_back({sample.head.tracks[random.below(track_count)].id, time, random.below(2) == 0,
                               random_bytes(random, size), 0, 0});
  }
  for (std::int64_t at = random.below(1'000'000); at < time; at += 1 + random.below(2'000'000'000))
    sample.head.chapters.push_back({at, "Chäpter " + std::to_string(at)});
  return sample;
}

inline void write_sample(const SampleFile& sample, const std::filesystem::path& path) {
  Writer writer(path, sample.head);
  for (const Payload& payload : sample.payloads) {
    writer.write(payload.track, payload.time_ns, payload.key, payload.bytes);
  }
  writer.finish();
}

} // namespace kinora::container::testing
