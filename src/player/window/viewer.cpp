#include "player/window/viewer.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/error.h"
#include "player/subject.h"
#include "player/window/new_file.h"

namespace kinora::player::window {
namespace {

using namespace std::chrono_literals;

constexpr auto kRest = 200ms;          // without a movement, until the whole picture is drawn
constexpr auto kBetweenCameras = 33ms; // of a recording

} // namespace

Viewer::Viewer(const std::string& clip, Open open, std::filesystem::path folder, std::function<bool()> stopped,
               MasterClock seconds, SoundPlayback::OpenLoudspeaker loudspeaker)
    : open_(std::move(open)), folder_(std::move(folder)), stopped_(std::move(stopped)), seconds_(std::move(seconds)),
      sound_(std::move(loudspeaker), seconds_) {
  start(clip);
}

// Changes nothing if the clip cannot be opened.
void Viewer::start(const std::string& clip) {
  std::unique_ptr<ClipFeed> feed = open_(clip);
  const ClipSoFar so_far = feed->first(stopped_);
  feed_ = std::move(feed);
  const std::filesystem::path path = clip;
  panel_.title = path.filename().string();
  name_ = path.stem().string();
  drawn_frame_ = 0;
  panel_.layers.clear();
  panel_.view = 0;
  clock_.reset();
  sound_.set_sound(nullptr);
  take(so_far);
  panel_.message = so_far.message;
  begins_ = true;
}

// Another part of the same clip, or the first: what a person has chosen stays.
void Viewer::take(const ClipSoFar& so_far) {
  const Player& player = *so_far.player;
  const clip::Clip& content = player.clip();
  const std::vector<double>& times = so_far.complete ? content.times : so_far.times; // what will not come is left out
  if (!clock_) {
    clock_.emplace(times, seconds_);
    camera_.reset();
  }
  if (!camera_ || !camera_->moved()) camera_.emplace(content.capture_camera(0), subject_of(player, 0));
  clock_->set_times(times, !so_far.complete, so_far.there);
  if (content.sound) sound_.set_sound({so_far.player, &*content.sound});
  std::vector<std::pair<std::string, bool>> layers;
  for (const clip::Layer& layer : content.layers) {
    const auto known = std::find_if(panel_.layers.begin(), panel_.layers.end(),
                                    [&](const auto& shown) { return shown.first == layer.name; });
    layers.emplace_back(layer.name, known == panel_.layers.end() || known->second);
  }
  panel_.layers = std::move(layers);
  panel_.first_seconds = times.front();
  panel_.last_seconds = times.back();
  panel_.frame_count = times.size();
  so_far_ = so_far;
  changed_ = true;
}

void Viewer::take_what_has_come() {
  if (so_far_.complete) return;
  const ClipSoFar newest = feed_->newest();
  if (newest.message != so_far_.message) panel_.message = newest.message;
  if (newest.player != so_far_.player || newest.complete) take(newest);
  so_far_ = newest;
}

std::pair<int, int> Viewer::wanted_size() const {
  const Intrinsics& capture = so_far_.player->clip().intrinsics;
  const double scale = std::min(960.0 / capture.width, 720.0 / capture.height);
  const auto scaled = [&](int size) { return std::max(1, static_cast<int>(std::lround(scale * size))); };
  return {scaled(capture.width), scaled(capture.height)};
}

void Viewer::act(const Action& action) {
  using enum Action::Kind;
  switch (action.kind) {
  case kPlayPause:
    if (std::exchange(begins_, false)) break;
    clock_->playing() ? clock_->pause() : clock_->play();
    break;
  case kStep:
    begins_ = false;
    clock_->step(static_cast<int>(action.value));
    fetch_what_is_sought();
    break;
  case kSeek:
    clock_->seek(action.value);
    fetch_what_is_sought();
    break;
  case kSeekBy:
    clock_->seek(clock_->seconds() + action.value);
    fetch_what_is_sought();
    break;
  case kLoop:
    clock_->set_loop(!clock_->loop());
    break;
  case kSpeed:
    clock_->set_speed(std::clamp(clock_->speed() * action.value, PlaybackClock::kMinSpeed, PlaybackClock::kMaxSpeed));
    break;
  case kMute:
    sound_.set_muted(!sound_.muted());
    break;
  case kHome:
    camera_->reset();
    changed_ = true;
    break;
  case kLayer:
    if (const auto i = static_cast<std::size_t>(action.value); i < panel_.layers.size()) {
      panel_.layers[i].second = !panel_.layers[i].second;
      changed_ = true;
    }
    break;
  case kView:
    set_view(static_cast<int>(action.value));
    break;
  case kScreenshot:
    screenshot_wanted_ = true;
    panel(width_, height_); // of the frame that is due now
    break;
  case kRecord:
    recording_ ? end_recording() : void(recording_.emplace());
    break;
  case kPanel:
    panel_.shown = !panel_.shown;
    break;
  case kQuit:
    ended_ = true;
    break;
  }
}

void Viewer::fetch_what_is_sought() {
  if (!clock_->is_there(clock_->frame())) feed_->seek(clock_->seconds());
}

void Viewer::set_view(int view) {
  const auto& clip_layers = so_far_.player->clip().layers;
  if (static_cast<PictureView>(view) == PictureView::kConfidence &&
      std::any_of(clip_layers.begin(), clip_layers.end(), [](const clip::Layer& layer) { return !layer.confidence; })) {
    panel_.message = "this clip does not say how well it was seen: an earlier Kinora made it";
    return;
  }
  panel_.view = view;
  changed_ = true;
}

void Viewer::orbit(double right, double down) {
  camera_->orbit(right, down);
  changed_ = true;
}

void Viewer::pan(double right, double down) {
  camera_->pan(right, down);
  changed_ = true;
}

void Viewer::zoom(double steps) {
  camera_->zoom(steps);
  changed_ = true;
}

void Viewer::open(const std::string& clip) {
  try {
    start(clip);
  } catch (const std::exception& error) {
    panel_.message = error.what();
  }
}

LayerChoice Viewer::layers() const {
  LayerChoice chosen;
  for (std::size_t i = 0; i < panel_.layers.size(); ++i) {
    if (panel_.layers[i].second) chosen.push_back(i);
  }
  return chosen;
}

PictureRequest Viewer::wanted(bool moving) const {
  return {so_far_.player, camera_->camera(width_, height_),      static_cast<double>(drawn_frame_),
          layers(),       static_cast<PictureView>(panel_.view), moving};
}

const Panel& Viewer::panel(int width, int height) {
  take_what_has_come();
  if (begins_ && so_far_.player->readiness() == Readiness::kWhole) {
    begins_ = false;
    clock_->play();
  }
  sound_.follow(*clock_);
  if (std::string message = sound_.take_message(); !message.empty()) panel_.message = std::move(message);
  const std::size_t frame = clock_->frame();
  const bool is_there = clock_->is_there(frame); // until it is, the last picture stays, and turns with the camera
  if (width != width_ || height != height_ || (is_there && frame != drawn_frame_)) changed_ = true;
  if (is_there) drawn_frame_ = frame;
  width_ = std::clamp(width, 1, 8192);
  height_ = std::clamp(height, 1, 8192);
  panel_.frame = frame;
  camera_->set_home(so_far_.player->clip().capture_camera(static_cast<double>(drawn_frame_)));
  panel_.seconds = clock_->seconds();
  panel_.playing = clock_->playing();
  panel_.loop = clock_->loop();
  panel_.has_sound = sound_.has_sound();
  panel_.muted = sound_.muted();
  panel_.speed = clock_->speed();
  panel_.recording = recording_.has_value();
  if (std::string message = worker_.take_message(); !message.empty()) panel_.message = std::move(message);
  draw_what_changed();
  if (so_far_.player->readiness() == Readiness::kWhole) save_screenshot();
  record();
  count_pictures();
  return panel_;
}

void Viewer::draw_what_changed() {
  const auto now = Clock::now();
  if (changed_) {
    if (tell_camera_) tell_camera_(camera_->camera(width_, height_).camera_to_world);
    changed_ = false;
    full_wanted_ = true;
    moved_ = now;
    worker_.request(wanted(true));
  } else if (full_wanted_ && !panel_.playing && now - moved_ >= kRest) {
    full_wanted_ = false;
    worker_.request(wanted(false));
  }
}

void Viewer::save_screenshot() {
  if (std::exchange(screenshot_wanted_, false))
    worker_.save(wanted(false), folder_, fmt::format("{}-{:06d}", name_, drawn_frame_));
}

void Viewer::count_pictures() {
  const auto now = Clock::now();
  const double passed = std::chrono::duration<double>(now - counted_).count();
  if (passed >= 0.5) {
    const std::size_t count = worker_.drawn();
    rate_ = static_cast<double>(count - count_) / passed;
    count_ = count;
    counted_ = now;
  }
  const DrawnPicture newest = worker_.newest();
  if (!newest.image) return;
  panel_.statistics = fmt::format("{}x{}{}  {:.0f} ms  {:.0f} pictures/s", newest.image->width(),
                                  newest.image->height(), newest.full ? " full" : "", newest.milliseconds, rate_);
}

void Viewer::record() {
  const auto now = Clock::now();
  if (!recording_ || now - recorded_ < kBetweenCameras) return;
  recorded_ = now;
  recording_->add(camera_->camera(width_, height_), panel_.seconds);
}

void Viewer::end_recording() {
  const std::size_t count = recording_->size();
  const std::string text = recording_->text();
  recording_.reset();
  if (count == 0) return;
  try {
    const auto path = write_new_file(folder_, "transforms", ".json", std::as_bytes(std::span(text)));
    panel_.message = fmt::format("{} written, {} cameras", path.filename().string(), count);
  } catch (const std::exception& error) {
    panel_.message = error.what();
  }
}

std::string Viewer::finish() {
  if (recording_) end_recording();
  save_screenshot();
  worker_.finish_saving();
  if (std::string message = worker_.take_message(); !message.empty()) panel_.message = std::move(message);
  return panel_.message;
}

} // namespace kinora::player::window
