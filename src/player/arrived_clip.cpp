#include "player/arrived_clip.h"

#include <memory>
#include <vector>

#include "clip/arriving_clip.h"
#include "clip/missing_parts.h"
#include "container/reader.h"
#include "core/error.h"

namespace kinora::player {
namespace {

constexpr std::size_t kHeadBytes = 4096; // in which a file says what it is

std::unique_ptr<container::ByteSource> source_of(std::span<const std::byte> bytes, const std::string& name) {
  return std::make_unique<container::MemorySource>(bytes, name);
}

} // namespace

ArrivedClip read_arrived(std::span<const std::byte> bytes, const std::string& name, bool last) {
  ArrivedClip arrived;
  clip::Arrival arrival;
  try {
    arrived.clip = clip::read_arriving(source_of(bytes, name), arrival);
  } catch (const Error& error) {
    const bool known = error.code() == ErrorCode::kNotRecognised && bytes.size() >= kHeadBytes;
    if (known || last) throw;
  }
  if (!arrival.missing.empty()) arrived.missing = clip::missing_sentence(name, arrival.missing);
  arrived.layers = arrival.layers;
  arrived.times = std::move(arrival.times);
  arrived.there = std::move(arrival.there);
  // While nothing that moves has come, nothing says so of a frame.
  const std::size_t frames = arrived.clip ? arrived.clip->times.size() : 0;
  for (std::size_t f = frames; f < arrived.there.size(); ++f) arrived.there[f] = false;
  return arrived;
}

FileState state_of(std::span<const std::byte> bytes, const std::string& name) {
  try {
    // Not strictly: what is being written ends anywhere.
    const container::Reader reader(source_of(bytes, name), container::Reading::kSalvage);
    if (reader.finished()) return FileState::kFinished;
    return reader.truncated() ? FileState::kCut : FileState::kGrowing;
  } catch (const Error&) {
    return FileState::kFinished;
  }
}

} // namespace kinora::player
