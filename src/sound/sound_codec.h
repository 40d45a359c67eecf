// Sound in files of its own, to Opus, and to samples. FFmpeg's libav* do it, in a module (core/module.h) that is opened
// on first use.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "sound/sound_source.h"

namespace kinora::sound {

/// The first sound track of a file: WAVE, FLAC, Ogg, MP3, AAC, MP4, Matroska. Its packets as they are, if the codec is
/// one that Matroska has a name for; else as 16-bit samples. Nothing but this local file is opened. Throws Error:
/// kCorruptInput (naming the path; it holds no sound, too), kMissingComponent.
std::unique_ptr<SoundSource> open_sound(const std::filesystem::path& path);

/// The same sound for a clip, from time 0 on: as it is where it is compressed already (Opus, AAC, MP3, Vorbis), else as
/// Opus of 64 kb/s for each channel, of at most two. Throws Error: kCorruptInput, kMissingComponent.
container::Sound compact(container::Sound sound);

inline constexpr int kPlayedRate = 48'000; ///< Hz
inline constexpr int kPlayedChannels = 2;

/// Packets to samples. Not thread-safe.
class SoundDecoder {
public:
  virtual ~SoundDecoder() = default;
  /// Samples of kPlayedRate, left and right in turn, -1 to 1. A packet that is damaged gives none.
  virtual std::vector<float> decode(const container::Payload& packet) = 0;
  /// What comes next does not follow what came before.
  virtual void reset() = 0;
};
/// Throws Error: kCorruptInput (a codec that is not known, or damaged), kMissingComponent.
std::unique_ptr<SoundDecoder> make_sound_decoder(const container::Track& track);

/// What the module exports: kinora_functions() returns one.
struct SoundModule {
  std::unique_ptr<SoundSource> (*open)(const std::filesystem::path& path);
  container::Sound (*to_opus)(const container::Sound& sound);
  std::unique_ptr<SoundDecoder> (*make_decoder)(const container::Track& track);
};

} // namespace kinora::sound
