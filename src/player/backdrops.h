// Pictures of the layers that stay where they are, by cameras that draw again and again: only what moves is drawn anew.
#pragma once

#include <cstddef>
#include <functional>
#include <list>
#include <memory>
#include <mutex>

#include "clip/layer_choice.h"
#include "fields/rendering/renderer.h"

namespace kinora::player {

bool is_same(const Camera& a, const Camera& b);

/// What a picture of layers that stay where they are depends on.
struct StillView {
  Camera camera;
  fields::DrawOptions options;
  clip::LayerChoice layers;
  bool operator==(const StillView& other) const {
    return is_same(camera, other.camera) && options == other.options && layers == other.layers;
  }
};

/// The pictures of a few views. Thread-safe.
class Backdrops {
public:
  /// Of all pictures together; one alone may be larger.
  static constexpr std::size_t kMaxPixels = 2'000'000;
  static constexpr std::size_t kMaxViews = 8;

  /// Null when a view is asked for the first time, as it may be the last; then the picture that `draw` made of it.
  std::shared_ptr<const fields::Picture> picture_of(const StillView& view,
                                                    const std::function<fields::Picture()>& draw);

private:
  struct Known {
    StillView view;
    std::shared_ptr<const fields::Picture> picture; // null: not drawn yet
  };
  void forget_oldest();

  std::mutex mutex_;
  std::list<Known> known_; // the one asked for last is first
};

} // namespace kinora::player
