#include "player/window/sound_playback.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace kinora::player::window {
namespace {

constexpr double kRate = sound::kPlayedRate;
constexpr double kAhead = 0.5;  // seconds that the loudspeaker has in hand: a busy machine may keep the window waiting
constexpr double kPiece = 0.02; // of silence
constexpr double kRunIn = 0.1;  // that a decoder needs before what it gives is right
constexpr double kGap = 0.05;   // between packets, from which on it is one
constexpr double kJump = 0.01;  // of the clock, from which on sound is begun again
constexpr double kLongest = 1;  // without anything being taken: the device is gone
constexpr double kTakenAtOnce = Loudspeaker::kTakenAtOnce / kRate;

/// When what is decoded of a packet is to be heard.
double begin_of(const container::Sound& sound, std::size_t packet) {
  return 1e-9 * static_cast<double>(sound.packets[packet].time_ns - sound.track.media->delay_ns);
}

std::vector<float> silence(double seconds) {
  return std::vector<float>(sound::kPlayedChannels * static_cast<std::size_t>(std::lround(seconds * kRate)));
}

double duration_of(const std::vector<float>& samples) {
  return static_cast<double>(samples.size()) / (sound::kPlayedChannels * kRate);
}

} // namespace

SoundPlayback::SoundPlayback(OpenLoudspeaker open, MasterClock seconds)
    : open_(std::move(open)), seconds_(std::move(seconds)) {}

void SoundPlayback::set_sound(std::shared_ptr<const container::Sound> sound) {
  const bool other =
      !sound_ || !sound || sound->track.codec != sound_->track.codec || sound->packets.size() < sound_->packets.size();
  sound_ = std::move(sound);
  if (!other) return;
  decoder_.reset();
  given_up_ = false;
  begin_again_ = true;
}

void SoundPlayback::set_muted(bool muted) {
  muted_ = muted;
  begin_again_ = true; // what waits is of the other kind
}

void SoundPlayback::give_up(std::string why) {
  message_ = std::move(why);
  given_up_ = true;
}

bool SoundPlayback::can_sound() {
  if (!sound_ || given_up_) return false;
  try {
    if (!decoder_) decoder_ = sound::make_sound_decoder(sound_->track);
    if (!loudspeaker_) loudspeaker_ = open_();
    return true;
  } catch (const Error& error) {
    give_up(error.what());
    return false;
  }
}

void SoundPlayback::follow(PlaybackClock& clock) {
  const bool wanted = clock.playing() && !clock.starved() && clock.speed() == 1 && can_sound();
  const bool jumped = std::abs(clock.position() - from_ - heard()) > kJump;
  if (sounding_ && (!wanted || jumped || begin_again_)) stop(clock);
  begin_again_ = false;
  if (!wanted) return;
  if (!sounding_) start(clock);
  fill();
  if (seconds_() - taken_at_ > kLongest) {
    give_up("sound is no longer played: its device takes none");
    stop(clock);
  }
}

void SoundPlayback::start(PlaybackClock& clock) {
  from_ = given_until_ = clock.position();
  next_packet_ = 0;
  while (next_packet_ < sound_->packets.size() && begin_of(*sound_, next_packet_) < from_ - kRunIn) ++next_packet_;
  decoded_until_ = next_packet_ < sound_->packets.size() ? begin_of(*sound_, next_packet_) : from_;
  decoder_->reset();
  taken_ = heard_ = 0;
  taken_at_ = seconds_();
  sounding_ = true;
  clock.set_master([this] { return master(); });
}

void SoundPlayback::stop(PlaybackClock& clock) {
  clock.set_master(seconds_); // from what has been heard, before what waits is forgotten
  loudspeaker_->stop();
  before_ += heard_;
  sounding_ = false;
}

// A device takes many samples at once, and then none for a while, in which time goes on.
double SoundPlayback::heard() {
  if (!sounding_) return 0;
  const double now = seconds_();
  const double taken = given_until_ - from_ - static_cast<double>(loudspeaker_->waiting()) / kRate;
  if (taken > taken_) {
    taken_ = taken;
    taken_at_ = now;
  }
  heard_ = std::max(heard_, taken_ - kTakenAtOnce + std::min(now - taken_at_, kTakenAtOnce));
  return heard_;
}

void SoundPlayback::fill() {
  while (static_cast<double>(loudspeaker_->waiting()) < kAhead * kRate) {
    std::vector<float> piece = next_piece();
    if (muted_) std::ranges::fill(piece, 0.0F);
    loudspeaker_->play(piece);
    given_until_ += duration_of(piece);
  }
}

/// What follows given_until_, at least a sample.
std::vector<float> SoundPlayback::next_piece() {
  while (next_packet_ < sound_->packets.size()) {
    const double begin = begin_of(*sound_, next_packet_);
    if (std::abs(begin - decoded_until_) > kGap) decoded_until_ = begin;
    if (decoded_until_ > given_until_ + 1 / kRate)
      return silence(std::clamp(decoded_until_ - given_until_, 1 / kRate, kPiece));
    std::vector<float> samples = decoded();
    const double late = given_until_ - (decoded_until_ - duration_of(samples));
    const auto passed = std::min<std::size_t>(samples.size() / sound::kPlayedChannels,
                                              static_cast<std::size_t>(std::lround(std::max(late, 0.0) * kRate)));
    samples.erase(samples.begin(), samples.begin() + static_cast<std::ptrdiff_t>(sound::kPlayedChannels * passed));
    if (!samples.empty()) return samples;
  }
  return silence(kPiece);
}

std::vector<float> SoundPlayback::decoded() {
  std::vector<float> samples = decoder_->decode(sound_->packets[next_packet_++]);
  decoded_until_ += duration_of(samples);
  return samples;
}

} // namespace kinora::player::window
