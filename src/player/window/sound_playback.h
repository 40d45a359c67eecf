// A clip's sound, heard while its pictures are seen.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "container/sound.h"
#include "player/playback_clock.h"
#include "player/window/loudspeaker.h"
#include "sound/sound_codec.h"

namespace kinora::player::window {

/// Plays sound where a clock stands, and makes what has been heard that clock's master. Sound is heard at its own pace
/// alone: at another speed, or where it cannot be played, there is silence and the clock goes by `seconds`. Not
/// thread-safe.
class SoundPlayback {
public:
  using OpenLoudspeaker = std::function<std::unique_ptr<Loudspeaker>()>;

  /// The loudspeaker is opened when there is sound to be played.
  SoundPlayback(OpenLoudspeaker open, MasterClock seconds);

  /// Of the clip that is played, or more of it; null: there is none.
  void set_sound(std::shared_ptr<const container::Sound> sound);
  bool has_sound() const { return sound_ != nullptr; }
  void set_muted(bool muted);
  bool muted() const { return muted_; }

  /// To be called many times a second, before the clock is asked: plays on from where the clock stands, or stops. The
  /// clock must not be asked once this object is gone.
  void follow(PlaybackClock& clock);
  /// Why there is no sound; once.
  std::string take_message() { return std::exchange(message_, {}); }

private:
  bool can_sound();
  void give_up(std::string why);
  void start(PlaybackClock& clock);
  void stop(PlaybackClock& clock);
  double heard();
  double master() { return before_ + heard(); }
  void fill();
  std::vector<float> next_piece();
  std::vector<float> decoded();

  OpenLoudspeaker open_;
  MasterClock seconds_;
  std::unique_ptr<Loudspeaker> loudspeaker_;
  std::unique_ptr<sound::SoundDecoder> decoder_;
  std::shared_ptr<const container::Sound> sound_;
  bool muted_ = false;
  bool given_up_ = false;
  bool begin_again_ = false;
  std::string message_;

  bool sounding_ = false;
  double before_ = 0;               ///< the master's seconds when it began to sound
  double from_ = 0;                 ///< seconds of the clip, there
  double given_until_ = 0;          ///< seconds of the clip that the loudspeaker has been given
  std::size_t next_packet_ = 0;     ///< to be decoded
  double decoded_until_ = 0;        ///< seconds of the clip
  double taken_ = 0, taken_at_ = 0; ///< seconds that the device has taken, and when it took the last
  double heard_ = 0;                ///< seconds, since it began to sound
};

} // namespace kinora::player::window
