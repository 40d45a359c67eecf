#include "player/backdrops.h"

#include <algorithm>

namespace kinora::player {

bool is_same(const Camera& a, const Camera& b) {
  return a.intrinsics == b.intrinsics && a.camera_to_world.matrix() == b.camera_to_world.matrix();
}

std::shared_ptr<const fields::Picture> Backdrops::picture_of(const StillView& view,
                                                             const std::function<fields::Picture()>& draw) {
  const auto place_of = [&] {
    return std::find_if(known_.begin(), known_.end(), [&](const Known& known) { return known.view == view; });
  };
  {
    const std::lock_guard lock(mutex_);
    const auto place = place_of();
    if (place == known_.end()) {
      known_.push_front({view, nullptr});
      forget_oldest();
      return nullptr;
    }
    known_.splice(known_.begin(), known_, place);
    if (place->picture != nullptr) return place->picture;
  }
  auto picture = std::make_shared<const fields::Picture>(draw());
  const std::lock_guard lock(mutex_);
  if (const auto place = place_of(); place != known_.end()) place->picture = picture;
  forget_oldest();
  return picture;
}

void Backdrops::forget_oldest() {
  std::size_t pixels = 0, views = 0;
  const auto fits = [&](const Known& known) {
    if (known.picture != nullptr) pixels += known.picture->color.pixel_count();
    return ++views == 1 || (views <= kMaxViews && pixels <= kMaxPixels);
  };
  known_.erase(std::find_if_not(known_.begin(), known_.end(), fits), known_.end());
}

} // namespace kinora::player
