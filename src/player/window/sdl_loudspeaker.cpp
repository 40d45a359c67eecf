// The module loudspeaker: SDL's sound behind loudspeaker.h.
#include <SDL.h>

#include <fmt/format.h>

#include "core/error.h"
#include "player/window/loudspeaker.h"
#include "sound/sound_codec.h"

namespace kinora::player::window {
namespace {

[[noreturn]] void fail() {
  throw Error(ErrorCode::kMissingComponent, fmt::format("sound cannot be played: {}", SDL_GetError()));
}

/// SDL's sound alone, which takes none of the program's signals.
class Library {
public:
  Library() {
    SDL_SetHint(SDL_HINT_NO_SIGNAL_HANDLERS, "1");
    if (SDL_InitSubSystem(SDL_INIT_AUDIO) != 0) fail();
  }
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;
  ~Library() { SDL_QuitSubSystem(SDL_INIT_AUDIO); }
};

class SdlLoudspeaker final : public Loudspeaker {
public:
  SdlLoudspeaker() {
    SDL_AudioSpec wanted{};
    wanted.freq = sound::kPlayedRate;
    wanted.format = AUDIO_F32SYS;
    wanted.channels = sound::kPlayedChannels;
    wanted.samples = kTakenAtOnce;
    device_ = SDL_OpenAudioDevice(nullptr, 0, &wanted, nullptr, 0);
    if (device_ == 0) fail();
    SDL_PauseAudioDevice(device_, 0);
  }
  SdlLoudspeaker(const SdlLoudspeaker&) = delete;
  SdlLoudspeaker& operator=(const SdlLoudspeaker&) = delete;
  ~SdlLoudspeaker() override { SDL_CloseAudioDevice(device_); }

  void play(std::span<const float> samples) override {
    SDL_QueueAudio(device_, samples.data(), static_cast<Uint32>(samples.size_bytes()));
  }
  std::size_t waiting() const override {
    return SDL_GetQueuedAudioSize(device_) / (sizeof(float) * sound::kPlayedChannels);
  }
  void stop() override { SDL_ClearQueuedAudio(device_); }

private:
  Library library_;
  SDL_AudioDeviceID device_ = 0;
};

const LoudspeakerModule kModule = {[]() -> std::unique_ptr<Loudspeaker> { return std::make_unique<SdlLoudspeaker>(); }};

} // namespace
} // namespace kinora::player::window

extern "C" const kinora::player::window::LoudspeakerModule* kinora_functions() {
  return &kinora::player::window::kModule;
}
