// What `kinora play` does, but for the window itself: a clip, its clock, the camera, and what is drawn of it when.
#pragma once

#include <functional>

#include "player/clip_feed.h"
#include "player/playback_clock.h"
#include "player/window/camera_recording.h"
#include "player/window/orbit_camera.h"
#include "player/window/picture_worker.h"
#include "player/window/sound_playback.h"
#include "player/window/window_functions.h"

namespace kinora::player::window {

/// Not thread-safe; draws in a thread of its own.
class Viewer : public Shown {
public:
  /// From a path or an address.
  using Open = std::function<std::unique_ptr<ClipFeed>(const std::string&)>;

  /// Opens `clip`, and what is dropped later, by `open`; what prevents it comes out of here, but not out of a later
  /// one. Screenshots and camera paths go to `folder`. Ends when `stopped` says so. `seconds`: of the playback.
  Viewer(const std::string& clip, Open open, std::filesystem::path folder, std::function<bool()> stopped,
         MasterClock seconds = steady_clock(), SoundPlayback::OpenLoudspeaker loudspeaker = open_loudspeaker);

  /// From now on `told`, if it is not empty, is called with the pose of every picture's camera, camera to world.
  void tell_camera(std::function<void(const SE3&)> told) { tell_camera_ = std::move(told); }

  /// Of the picture of a new window, in pixels.
  std::pair<int, int> wanted_size() const;

  void act(const Action& action) override;
  void orbit(double right, double down) override;
  void pan(double right, double down) override;
  void zoom(double steps) override;
  void open(const std::string& clip) override;
  const Panel& panel(int width, int height) override;
  std::shared_ptr<const ColorImage> picture() override { return worker_.newest().image; }
  bool ended() const override { return ended_ || stopped_(); }

  /// Writes what is still to be written; gives the last message.
  std::string finish();

private:
  using Clock = std::chrono::steady_clock;

  void start(const std::string& clip);
  void take(const ClipSoFar& so_far);
  void take_what_has_come();
  void fetch_what_is_sought();
  PictureRequest wanted(bool moving) const;
  LayerChoice layers() const;
  void draw_what_changed();
  void save_screenshot();
  void record();
  void end_recording();
  void set_view(int view);
  void count_pictures();

  Open open_;
  std::filesystem::path folder_;
  std::function<bool()> stopped_;
  std::function<void(const SE3&)> tell_camera_;
  MasterClock seconds_;
  std::unique_ptr<ClipFeed> feed_;
  ClipSoFar so_far_;
  std::string name_; ///< of the clip's file, without extension
  SoundPlayback sound_;
  std::optional<PlaybackClock> clock_;
  std::optional<OrbitCamera> camera_;
  std::optional<CameraRecording> recording_;
  Clock::time_point recorded_;
  Panel panel_;
  int width_ = 1, height_ = 1;
  std::size_t drawn_frame_ = 0; ///< the last that was to be shown and had come
  bool begins_ = false;         ///< it plays as soon as more than a first look is ready: its sound comes with that
  bool changed_ = true;         ///< something is to be drawn that was not yet asked for
  bool full_wanted_ = true;
  bool screenshot_wanted_ = false; ///< as soon as more than a first look is ready
  Clock::time_point moved_;
  Clock::time_point counted_;
  std::size_t count_ = 0;
  double rate_ = 0; ///< pictures per second
  bool ended_ = false;
  PictureWorker worker_; // last: its thread ends first
};

} // namespace kinora::player::window
