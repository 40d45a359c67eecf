// A thread of its own that draws what the window wants to show, so that the window never waits.
#pragma once

#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "player/picture_view.h"
#include "player/player.h"
#include "player/window/moving_resolution.h"

namespace kinora::player::window {

struct PictureRequest {
  std::shared_ptr<const Player> player;
  Camera camera; ///< of the whole window
  double frame = 0;
  LayerChoice layers;
  PictureView view = PictureView::kColor;
  bool moving = false; ///< smaller, and soon; at rest the size of the window and every sample
};

struct DrawnPicture {
  std::shared_ptr<const ColorImage> image;
  double milliseconds = 0;
  bool full = false;
};

/// Draws the newest request; requests that came meanwhile are dropped. Thread-safe.
class PictureWorker {
public:
  PictureWorker();
  PictureWorker(const PictureWorker&) = delete;
  PictureWorker& operator=(const PictureWorker&) = delete;

  void request(PictureRequest request);
  /// Draws at full quality and writes to NAME.png, or NAME-2.png… where that is taken, in `folder`.
  void save(PictureRequest request, const std::filesystem::path& folder, const std::string& name);

  DrawnPicture newest() const;
  std::size_t drawn() const; ///< pictures so far
  /// What became of a picture that was to be saved; empty: nothing new.
  std::string take_message();
  /// Until everything that was to be saved is.
  void finish_saving();

private:
  struct Saving {
    PictureRequest request;
    std::filesystem::path folder;
    std::string name;
  };
  void work(const std::stop_token& stop);
  void draw(const PictureRequest& request);
  void write(const Saving& saving);

  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::optional<PictureRequest> next_;
  std::vector<Saving> saving_;
  DrawnPicture newest_;
  std::size_t drawn_ = 0;
  std::string message_;
  // The worker's own. While the camera rests, pictures of one size cost less from the third on (player/backdrops.h).
  MovingResolution while_camera_moves_, while_camera_rests_;
  Camera last_camera_, last_drawn_camera_;
  int drawn_from_there_ = 0;
  std::jthread thread_;
};

} // namespace kinora::player::window
