// What sound is given to: a device of the system's, through SDL in a module (core/module.h) of its own.
#pragma once

#include <cstddef>
#include <memory>
#include <span>

namespace kinora::player::window {

/// Not thread-safe.
class Loudspeaker {
public:
  /// Samples of one side that the device takes at once. A device that has just taken some has those before still to be
  /// heard.
  static constexpr std::size_t kTakenAtOnce = 512;

  virtual ~Loudspeaker() = default;
  /// Samples of sound::kPlayedRate, left and right in turn, to be heard behind those before.
  virtual void play(std::span<const float> samples) = 0;
  /// Samples of one side that the device has not taken yet.
  virtual std::size_t waiting() const = 0;
  /// Forgets those.
  virtual void stop() = 0;
};

/// Throws Error(kMissingComponent) if there is no device, or no module, or a library that it needs is not installed.
std::unique_ptr<Loudspeaker> open_loudspeaker();

/// What the module exports: kinora_functions() returns one.
struct LoudspeakerModule {
  std::unique_ptr<Loudspeaker> (*open)();
};

} // namespace kinora::player::window
