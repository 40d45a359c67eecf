#include "clip/payloads/update_codec.h"

#include <fmt/format.h>

#include "container/little_endian.h"
#include "core/error.h"

namespace kinora::clip {

using container::get;
using container::put;

namespace {

constexpr std::uint8_t kVersion = 1;
constexpr std::size_t kHeaderBytes = 12;
constexpr std::size_t kEntryBytes = 12;
constexpr std::uint32_t kKeyFrame = std::uint32_t{1} << 31;

[[noreturn]] void corrupt(const std::string& location, const std::string& why) {
  throw Error(ErrorCode::kCorruptInput, fmt::format("{}: {}", location, why));
}

} // namespace

Bytes encode_update(const UpdateView& update) {
  Bytes out;
  put(out, kVersion);
  put(out, std::uint8_t{0});
  put(out, std::uint16_t{0});
  put(out, update.key);
  put(out, static_cast<std::uint32_t>(update.parts.size()));
  for (const PartView& part : update.parts) {
    put(out, static_cast<std::uint16_t>(part.what));
    put(out, part.track);
    put(out, part.from_key);
    put(out, static_cast<std::uint32_t>(part.bytes.size()));
  }
  for (const PartView& part : update.parts) out.insert(out.end(), part.bytes.begin(), part.bytes.end());
  return out;
}

UpdateView decode_update(std::span<const std::byte> payload, const std::string& location) {
  if (payload.size() < kHeaderBytes) corrupt(location, "an update is too short for its header");
  if (const auto version = get<std::uint8_t>(payload, 0); version != kVersion)
    corrupt(location, fmt::format("an update has version {}; this Kinora reads version {}", version, kVersion));
  UpdateView update;
  update.key = get<std::uint32_t>(payload, 4);
  const auto count = std::size_t{get<std::uint32_t>(payload, 8)};
  if (count > (payload.size() - kHeaderBytes) / kEntryBytes) corrupt(location, "an update is too short for its parts");
  std::size_t at = kHeaderBytes + kEntryBytes * count;
  for (std::size_t p = 0; p < count; ++p) {
    const std::size_t entry = kHeaderBytes + kEntryBytes * p;
    const auto what = get<std::uint16_t>(payload, entry);
    const auto bytes = std::size_t{get<std::uint32_t>(payload, entry + 8)};
    if (bytes > payload.size() - at) corrupt(location, "an update is too short for its parts");
    if (what <= static_cast<std::uint16_t>(UpdatePart::kBirths)) {
      update.parts.push_back({static_cast<UpdatePart>(what), get<std::uint16_t>(payload, entry + 2),
                              get<std::uint32_t>(payload, entry + 4), payload.subspan(at, bytes)});
    }
    at += bytes;
  }
  if (at != payload.size()) corrupt(location, "an update's parts do not add up to its size");
  return update;
}

void append_frame(Bytes& part, const FrameView& frame) {
  put(part, static_cast<std::uint32_t>(frame.bytes.size()) | (frame.key ? kKeyFrame : 0));
  part.insert(part.end(), frame.bytes.begin(), frame.bytes.end());
}

std::vector<FrameView> frames_of(std::span<const std::byte> part, const std::string& location) {
  std::vector<FrameView> frames;
  for (std::size_t at = 0; at < part.size();) {
    if (part.size() - at < 4) corrupt(location, "the frames of a motion do not add up to its size");
    const auto head = get<std::uint32_t>(part, at);
    const std::size_t bytes = head & ~kKeyFrame;
    at += 4;
    if (bytes > part.size() - at) corrupt(location, "the frames of a motion do not add up to its size");
    frames.push_back({(head & kKeyFrame) != 0, part.subspan(at, bytes)});
    at += bytes;
  }
  return frames;
}

} // namespace kinora::clip
