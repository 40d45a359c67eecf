#include "container/envelope.h"

#include <array>
#include <charconv>

#include <fmt/format.h>

#include "container/crc32c.h"
#include "container/little_endian.h"
#include "core/error.h"

namespace kinora::container {

namespace {

constexpr std::uint8_t kEnvelopeVersion = 1;
constexpr std::uint8_t kKeyFlag = 1;
constexpr std::size_t kChecksumAt = 4;
constexpr std::size_t kPrivateChecksumAt = 8;
constexpr std::array<std::byte, 4> kPrivateMagic{std::byte{'K'}, std::byte{'N'}, std::byte{'R'}, std::byte{'A'}};
constexpr std::string_view kDescriptionMark = "crc32c:";
constexpr std::size_t kDigits = 8;

// Checksum of everything but the four bytes that hold it.
std::uint32_t checksum_around(std::span<const std::byte> bytes, std::size_t hole) {
  return crc32c(bytes.subspan(hole + 4), crc32c(bytes.first(hole)));
}

void store_checksum(Bytes& bytes, std::size_t hole) {
  const std::uint32_t crc = checksum_around(bytes, hole);
  for (std::size_t i = 0; i < 4; ++i) bytes[hole + i] = static_cast<std::byte>(crc >> (8 * i) & 0xFF);
}

[[noreturn]] void corrupt(const std::string& location, const std::string& why) {
  throw Error(ErrorCode::kCorruptInput, fmt::format("{}: {}", location, why));
}

} // namespace

Bytes wrap_payload(std::uint16_t track, std::int64_t time_ns, bool key, std::span<const std::byte> bytes) {
  if (time_ns < 0) {
    throw Error(ErrorCode::kFailure, fmt::format("a payload of track {} has the negative time {} ns", track, time_ns));
  }
  Bytes out;
  out.reserve(kEnvelopeBytes + bytes.size());
  put(out, kEnvelopeVersion);
  put(out, static_cast<std::uint8_t>(key ? kKeyFlag : 0));
  put(out, track);
  put(out, std::uint32_t{0});
  put(out, time_ns);
  out.insert(out.end(), bytes.begin(), bytes.end());
  store_checksum(out, kChecksumAt);
  return out;
}

Payload unwrap_payload(std::uint16_t track, std::span<const std::byte> block, const std::string& location) {
  if (block.size() < kEnvelopeBytes) corrupt(location, fmt::format("a payload of {} bytes is too short", block.size()));
  if (checksum_around(block, kChecksumAt) != get<std::uint32_t>(block, kChecksumAt)) {
    corrupt(location, "a payload does not match its checksum; the file is damaged, fetch it again");
  }
  const auto version = get<std::uint8_t>(block, 0);
  if (version != kEnvelopeVersion) {
    corrupt(location, fmt::format("a payload has envelope version {}, which this Kinora does not know", version));
  }
  Payload payload;
  payload.track = get<std::uint16_t>(block, 2);
  payload.key = (get<std::uint8_t>(block, 1) & kKeyFlag) != 0;
  payload.time_ns = get<std::int64_t>(block, 8);
  if (payload.track != track) {
    corrupt(location, fmt::format("a payload of track {} lies in track {}", payload.track, track));
  }
  if (payload.time_ns < 0) corrupt(location, fmt::format("a payload has the negative time {} ns", payload.time_ns));
  payload.bytes.assign(block.begin() + kEnvelopeBytes, block.end());
  return payload;
}

Bytes wrap_private(const Track& track) {
  Bytes out(kPrivateMagic.begin(), kPrivateMagic.end());
  put(out, kEnvelopeVersion);
  put(out, std::uint8_t{0});
  put(out, track.id);
  put(out, std::uint32_t{0});
  out.insert(out.end(), track.private_data.begin(), track.private_data.end());
  store_checksum(out, kPrivateChecksumAt);
  return out;
}

void unwrap_private(std::span<const std::byte> codec_private, Track& track, const std::string& location) {
  if (codec_private.size() < kPrivateHeaderBytes ||
      !std::equal(kPrivateMagic.begin(), kPrivateMagic.end(), codec_private.begin())) {
    corrupt(location, "the private data of a track does not begin with KNRA");
  }
  if (checksum_around(codec_private, kPrivateChecksumAt) != get<std::uint32_t>(codec_private, kPrivateChecksumAt)) {
    corrupt(location, "the private data of a track does not match its checksum; the file is damaged, fetch it again");
  }
  const auto version = get<std::uint8_t>(codec_private, 4);
  if (version != kEnvelopeVersion) {
    corrupt(location, fmt::format("a track has private data of version {}, which this Kinora does not know", version));
  }
  track.id = get<std::uint16_t>(codec_private, 6);
  track.private_data.assign(codec_private.begin() + kPrivateHeaderBytes, codec_private.end());
}

std::string with_checksum(const std::string& description, std::span<const std::byte> bytes) {
  return fmt::format("{}{}{}{:08x}", description, description.empty() ? "" : " ", kDescriptionMark, crc32c(bytes));
}

std::optional<std::uint32_t> take_checksum(std::string& description) {
  const std::size_t length = kDescriptionMark.size() + kDigits;
  if (description.size() < length) return std::nullopt;
  const std::size_t mark = description.size() - length;
  if (description.compare(mark, kDescriptionMark.size(), kDescriptionMark) != 0) return std::nullopt;
  const char* const digits = description.data() + mark + kDescriptionMark.size();
  std::uint32_t crc = 0;
  const auto [end, error] = std::from_chars(digits, digits + kDigits, crc, 16);
  if (error != std::errc{} || end != digits + kDigits) return std::nullopt;
  description.resize(mark > 0 ? mark - 1 : 0);
  return crc;
}

} // namespace kinora::container
