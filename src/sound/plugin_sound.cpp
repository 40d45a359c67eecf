#include "sound/plugin_sound.h"

#include <cmath>
#include <limits>

#include "core/error.h"

namespace kinora::sound {
namespace {

constexpr double kNanoseconds = 1e9;
constexpr double kLongest = 1e9;                               // seconds
constexpr double kMaxRate = 1e6;                               // Hz
constexpr int kMaxChannels = 64;                               //
constexpr std::size_t kMaxPrivateBytes = std::size_t{1} << 20; // Vorbis has some ten thousand
constexpr std::size_t kMaxPacketBytes = std::size_t{16} << 20;

container::Bytes bytes_of(const void* data, std::size_t size) {
  const auto* bytes = static_cast<const std::byte*>(data);
  return {bytes, bytes + size};
}

[[noreturn]] void refuse(const char* fault) {
  throw Error(ErrorCode::kFailure, std::string("the plugin gave sound ").append(fault));
}

} // namespace

void fill(KinoraSound& sound, const container::Track& track) {
  const container::MediaFormat media = track.media.value_or(container::MediaFormat{});
  sound.codec = track.codec.c_str();
  sound.private_data = track.private_data.empty() ? nullptr : track.private_data.data();
  sound.private_bytes = track.private_data.size();
  sound.sampling_rate = media.sampling_rate;
  sound.channels = media.channels;
  sound.bits = media.bits;
  sound.delay = static_cast<double>(media.delay_ns) / kNanoseconds;
}

container::Track track_of(const KinoraSound& sound) {
  if (sound.codec == nullptr || std::string_view(sound.codec).substr(0, 2) != "A_") refuse("of no codec for sound");
  if (!(sound.sampling_rate >= 1 && sound.sampling_rate <= kMaxRate) || sound.channels < 1 ||
      sound.channels > kMaxChannels || sound.bits < 0 || !(sound.delay >= 0 && sound.delay < kLongest))
    refuse("with an absurd rate, number of channels or delay");
  if (sound.private_bytes > kMaxPrivateBytes || (sound.private_bytes > 0 && sound.private_data == nullptr))
    refuse("without the data of its codec");
  container::Track track;
  track.id = container::kSoundTrack;
  track.codec = sound.codec;
  if (sound.private_bytes > 0) track.private_data = bytes_of(sound.private_data, sound.private_bytes);
  track.media.emplace();
  track.media->sampling_rate = static_cast<int>(std::lround(sound.sampling_rate));
  track.media->channels = sound.channels;
  track.media->bits = sound.bits;
  track.media->delay_ns = std::llround(sound.delay * kNanoseconds);
  return track;
}

void fill(KinoraSoundPacket& packet, const container::Payload& payload, double start_time) {
  packet.time = start_time + static_cast<double>(payload.time_ns) / kNanoseconds;
  packet.data = payload.bytes.data();
  packet.bytes = payload.bytes.size();
}

container::Payload payload_of(const KinoraSoundPacket& packet, double start_time) {
  const double time = packet.time - start_time;
  if (!(std::abs(time) < kLongest)) refuse("at a time that makes no sense");
  if (packet.data == nullptr || packet.bytes == 0 || packet.bytes > kMaxPacketBytes) refuse("of no or too many bytes");
  container::Payload payload;
  payload.track = container::kSoundTrack;
  payload.time_ns = std::llround(time * kNanoseconds);
  payload.key = true;
  payload.bytes = bytes_of(packet.data, packet.bytes);
  return payload;
}

} // namespace kinora::sound
