#include "player/window/picture_worker.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <fmt/format.h>

#include "core/image_codec.h"
#include "player/window/new_file.h"

namespace kinora::player::window {
namespace {

using Clock = std::chrono::steady_clock;

ColorImage drawn(const PictureRequest& request) {
  const fields::DrawOptions options = draw_options_for(request.view);
  return painted(request.moving ? request.player->preview(request.camera, request.frame, request.layers, options)
                                : request.player->draw(request.camera, request.frame, request.layers, options),
                 request.view, request.player->drawn_health(request.frame, request.layers));
}

} // namespace

PictureWorker::PictureWorker() : thread_([this](const std::stop_token& stop) { work(stop); }) {}

void PictureWorker::request(PictureRequest request) {
  const std::lock_guard lock(mutex_);
  next_ = std::move(request);
  changed_.notify_all();
}

void PictureWorker::save(PictureRequest request, const std::filesystem::path& folder, const std::string& name) {
  request.moving = false;
  const std::lock_guard lock(mutex_);
  saving_.push_back({std::move(request), folder, name});
  changed_.notify_all();
}

DrawnPicture PictureWorker::newest() const {
  const std::lock_guard lock(mutex_);
  return newest_;
}

std::size_t PictureWorker::drawn() const {
  const std::lock_guard lock(mutex_);
  return drawn_;
}

std::string PictureWorker::take_message() {
  const std::lock_guard lock(mutex_);
  return std::exchange(message_, {});
}

void PictureWorker::finish_saving() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return saving_.empty(); });
}

void PictureWorker::work(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [this] { return next_ || !saving_.empty(); })) {
    if (!saving_.empty()) {
      const Saving saving = saving_.front();
      lock.unlock();
      write(saving);
      lock.lock();
      saving_.erase(saving_.begin());
      changed_.notify_all();
    } else {
      const PictureRequest request = *std::exchange(next_, std::nullopt);
      lock.unlock();
      try {
        draw(request);
      } catch (const std::exception& error) {
        const std::lock_guard again(mutex_);
        message_ = error.what();
      }
      lock.lock();
    }
  }
}

void PictureWorker::draw(const PictureRequest& request) {
  PictureRequest smaller = request;
  const Intrinsics& full = request.camera.intrinsics;
  const bool rests = is_same(request.camera, last_camera_);
  last_camera_ = request.camera;
  MovingResolution& resolution = rests ? while_camera_rests_ : while_camera_moves_;
  if (request.moving) {
    const double scale = resolution.scale();
    smaller.camera.intrinsics = full.resized(std::max(1, static_cast<int>(std::lrint(scale * full.width))),
                                             std::max(1, static_cast<int>(std::lrint(scale * full.height))));
  }
  const auto start = Clock::now();
  auto image = std::make_shared<const ColorImage>(window::drawn(smaller));
  const double milliseconds = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
  drawn_from_there_ = is_same(smaller.camera, last_drawn_camera_) ? drawn_from_there_ + 1 : 1;
  last_drawn_camera_ = smaller.camera;
  if (request.moving && (!rests || drawn_from_there_ > 2)) resolution.took(milliseconds);
  const std::lock_guard lock(mutex_);
  newest_ = {std::move(image), milliseconds, !request.moving};
  ++drawn_;
}

void PictureWorker::write(const Saving& saving) {
  std::string message;
  try {
    const Bytes png = encode_png(window::drawn(saving.request));
    message = fmt::format("{} written", write_new_file(saving.folder, saving.name, ".png", png).filename().string());
  } catch (const std::exception& error) {
    message = error.what();
  }
  const std::lock_guard lock(mutex_);
  message_ = message;
}

} // namespace kinora::player::window
